import { byId } from "../../plant/places";
import { t } from "../../text/operator";
import { StopButton } from "./StopButton";

/** Stop for every vehicle near, by name and always at the same place, wherever the page is scrolled to. */
export function StopDock({ ids }: { ids: readonly string[] }) {
  const sorted = ids.map((id) => ({ id })).sort(byId);
  return (
    <div class="dock" role="group" aria-label={t("stop.dock")}>
      {sorted.map(({ id }) => (
        <StopButton key={id} atv={id} named />
      ))}
    </div>
  );
}
