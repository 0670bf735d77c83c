import type { AtvView } from "../../api/types";
import { format, t } from "../../text/operator";
import { give } from "../commands/given";
import { hindranceOf } from "../../commands/hindrance";
import { circumstancesOf } from "../state";

/** Parts of the vehicle's own top speed: what it may do at most, and steps below it. */
const STEPS = [0.25, 0.5, 0.75, 1];
/** The vehicle answers with the very number that it was told. */
const SAME = 1e-6;

export function SpeedSteps({ atv }: { atv: AtvView }) {
  const disabled = hindranceOf("set_speed", atv, circumstancesOf(atv)) !== null;
  return (
    <div class="steps" role="group" aria-label={t("steps.title", { atv: atv.id })}>
      <span aria-hidden="true">{t("steps.short")}</span>
      {STEPS.map((step) => {
        const percent = format.percent(step);
        return (
          <button
            key={step}
            type="button"
            aria-pressed={Math.abs(atv.speed_limit_frac - step) < SAME}
            aria-label={t("steps.stepLabel", { percent })}
            disabled={disabled}
            onClick={() => void give(atv.id, { kind: "set_speed", speed_frac: step })}
          >
            {percent}
          </button>
        );
      })}
    </div>
  );
}
