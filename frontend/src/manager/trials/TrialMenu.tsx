import { world } from "../../stream/stream";
import { t } from "../../text/manager";
import { PopButton } from "../PopButton";
import { begin, busy } from "./act";
import { faultsOf, isOn, type Trial } from "./trials";

/** A button for the head of a card: what may go wrong with this one. Absent in a real factory. */
export function TrialMenu({ agent, kinds }: { agent: string; kinds: readonly Trial[] }) {
  const known = world.value;
  if (!known?.trials) return null;
  const faults = faultsOf(known.faults.values(), agent);
  return (
    <PopButton icon="trial" label={t("trial.title")} title={t("trial.hint")}>
      {(close) => (
        <>
          <p class="faint">{t("trial.hint")}</p>
          {kinds.map((kind) => (
            <button
              key={kind}
              type="button"
              class="trial-choice"
              disabled={busy.value || isOn(faults, kind)}
              onClick={() => {
                close();
                void begin(kind, agent);
              }}
            >
              {t(`trial.begin.${kind}`)}
            </button>
          ))}
        </>
      )}
    </PopButton>
  );
}
