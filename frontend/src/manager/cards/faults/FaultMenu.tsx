import { world } from "../../../stream/stream";
import { t } from "../../../text/views/faults";
import { PopButton } from "../../parts/PopButton";
import { begin, busy } from "./act";
import { faultsOf, isOn, KINDS } from "./faults";

/** A button for the head of a card: what may go wrong with this one. */
export function FaultMenu({ agent, kind: of }: { agent: string; kind: keyof typeof KINDS }) {
  const faults = faultsOf(world.value?.faults.values() ?? [], agent);
  return (
    <PopButton icon="fault" label={t("fault.title")} title={t("fault.hint")}>
      {(close) => (
        <>
          <p class="faint">{t("fault.hint")}</p>
          {KINDS[of].map((kind) => (
            <button
              key={kind}
              type="button"
              class="fault-choice"
              disabled={busy.value || isOn(faults, kind)}
              onClick={() => {
                close();
                void begin(kind, agent);
              }}
            >
              {t(`fault.begin.${kind}`)}
            </button>
          ))}
        </>
      )}
    </PopButton>
  );
}
