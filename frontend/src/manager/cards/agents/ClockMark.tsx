import { useId } from "preact/hooks";
import type { ClockView } from "../../../api/types";
import { Tag } from "../../../parts/Tag";
import { t } from "../../../text/manager";
import { factoryTime } from "../../../text/plant-time";

/** Nothing is told more exactly: a heartbeat tells its time in hundredths. */
const LEAST_BOUND_S = 0.1;

/** That an agent's clock is wrong; how that is known and what to do about it, on hover and focus. */
export function ClockMark({ clock }: { clock: ClockView | null | undefined }) {
  const id = useId();
  if (!clock?.wrong) return null;
  const by = factoryTime(Math.abs(clock.ahead_s));
  return (
    <span class="clock-mark" tabIndex={0} aria-describedby={id}>
      <Tag tone="warn">{t(clock.ahead_s < 0 ? "clock.behind" : "clock.ahead", { by })}</Tag>
      <span id={id} role="tooltip" class="clock-why">
        {t("clock.why", { bound: factoryTime(Math.max(LEAST_BOUND_S, clock.bound_s), undefined, "price") })}
      </span>
    </span>
  );
}

/** The same below a fact, over the whole width of a list of facts. */
export function ClockFact({ clock }: { clock: ClockView | null | undefined }) {
  if (!clock?.wrong) return null;
  return (
    <dd class="fact-wide">
      <ClockMark clock={clock} />
    </dd>
  );
}
