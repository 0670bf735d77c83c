import { format, t } from "../../text";
import type { Heat } from "./heat";

/** What the shades of the lanes mean. */
export function HeatLegend({ heat }: { heat: Heat }) {
  const { steps } = heat;
  return (
    <div class="heat-legend">
      <span>{t(steps.length === 0 ? "map.heat.none" : "map.heat.title")}</span>
      <ul>
        {steps.map((from, step) => (
          <li key={step}>
            <i style={{ opacity: (step + 1) / steps.length }} aria-hidden="true" />
            <span class="num">{t("map.heat.from", { passes: format.count(from) })}</span>
          </li>
        ))}
      </ul>
    </div>
  );
}
