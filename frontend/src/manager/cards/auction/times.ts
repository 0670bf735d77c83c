/** The ledger of one task: when it was due, what was promised, what came of it. */
import type { TaskView } from "../../../api/types";
import { format, t } from "../../../text/manager";
import { factoryTime } from "../../../text/plant-time";

/** What would be shown as no second at all, in factory time. */
export const PUNCTUAL_S = 0.5;

export function taskTimes(task: TaskView, speed: number): string[] {
  const { closed_at_s: closed, promised_at_s: promised, state } = task;
  const times: string[] = [];
  if (state === "delivered" && closed !== null) {
    times.push(t("auction.delivered", { at: format.clock(closed) }));
    if (promised !== null) {
      const lateS = (closed - promised) * speed;
      const by = factoryTime(Math.abs(lateS), speed);
      const kept = Math.abs(lateS) < PUNCTUAL_S;
      times.push(kept ? t("auction.onTime") : t(lateS > 0 ? "auction.late" : "auction.early", { by }));
    }
    return times;
  }
  if (promised !== null) times.push(t("auction.promised", { at: format.clock(promised) }));
  times.push(t("auction.due", { at: format.clock(task.deadline_at_s) }));
  return times;
}
