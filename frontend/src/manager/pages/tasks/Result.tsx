/** What became of a promise, or that it is overdue, and what held its carrier up. */
import type { TaskRecord } from "../../../api/client";
import { nowS, world } from "../../../stream/stream";
import { factoryTime } from "../../../text/plant-time";
import { t } from "../../../text/views/records";
import { PUNCTUAL_S } from "../../cards/auction/times";
import { heldKey, machineHeldKey } from "../../parts/rows/held";
import { names } from "../../state";

type Ended = Pick<TaskRecord, "closed_at_s" | "held" | "held_by" | "held_s" | "kind" | "promised_at_s" | "state">;

export function Result({ task }: { task: Ended }) {
  const speed = world.value?.factory.speed ?? 1;
  const lateS = lateOf(task, nowS.value, speed);
  if (lateS === null) return null;
  const isOpen = task.state === "contracted";
  if (lateS < PUNCTUAL_S && isOpen) return null;
  if (Math.abs(lateS) < PUNCTUAL_S) return <span>{t("tasks.onTime")}</span>;
  const by = factoryTime(Math.abs(lateS), speed);
  if (lateS > 0) return <><span class="tone-warn">{t(isOpen ? "tasks.overdue" : "tasks.broken", { by })}</span><Cause task={task} /></>;
  return <span>{t("tasks.kept", { by })}</span>;
}

/** How much later than promised it was done, or is not done yet, in the factory's seconds; negative for sooner, null where that says nothing. */
export function lateOf({ closed_at_s: closedS, promised_at_s: promisedS, state }: Ended, nowS: number, speed: number): number | null {
  const endS = state === "contracted" ? nowS : state === "delivered" ? closedS : null;
  return endS === null || promisedS === null ? null : (endS - promisedS) * speed;
}

/** What held its carrier up, where that was long enough to be why it was late. */
function Cause({ task }: { task: Ended }) {
  const { held: doing, held_by: by, kind } = task;
  const held = kind === "transport" ? heldKey(doing, by) : machineHeldKey(doing, by);
  if (held === null) return null;
  const speed = world.value?.factory.speed ?? 1;
  const said = { time: factoryTime(task.held_s * speed, speed), by: kind === "transport" ? by : names.value(by) };
  return <small class="line">{t(`held.${held}`, said)}</small>;
}
