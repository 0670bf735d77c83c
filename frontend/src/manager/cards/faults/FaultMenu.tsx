import { world } from "../../../stream/stream";
import { t } from "../../../text/manager";
import { PopButton } from "../../parts/PopButton";
import { begin, busy } from "./act";
import { faultsOf, isOn, type FaultKind } from "./faults";

/** A button for the head of a card: what may go wrong with this one. Absent in a real factory. */
export function FaultMenu({ agent, kinds }: { agent: string; kinds: readonly FaultKind[] }) {
  const known = world.value;
  if (!known?.fault_injection) return null;
  const faults = faultsOf(known.faults.values(), agent);
  return (
    <PopButton icon="fault" label={t("fault.title")} title={t("fault.hint")}>
      {(close) => (
        <>
          <p class="faint">{t("fault.hint")}</p>
          {kinds.map((kind) => (
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
