import { useSignal } from "@preact/signals";
import { t } from "../../text/manager";
import { Later } from "../../parts/Later";
import { PopButton } from "../parts/PopButton";

const loadSigns = async () => (await import("./guide/Signs")).load();

/** What the signs of the map mean, beside the switches of its layers. */
export function Legend() {
  const opened = useSignal(false);
  return (
    <PopButton icon="question" label={t("legend.open")} title={t("legend.title")} onToggle={(open) => { opened.value ||= open; }}>
      {() => opened.value && <Later load={loadSigns} />}
    </PopButton>
  );
}
