/** What became of a promise, and what held its carrier up. */
import type { TaskRecord } from "../../../api/client";
import { world } from "../../../stream/stream";
import { factoryTime } from "../../../text/plant-time";
import { t } from "../../../text/views/records";
import { PUNCTUAL_S } from "../../cards/auction/times";
import { heldKey, machineHeldKey } from "../../parts/rows/held";
import { names } from "../../state";

type Ended = Pick<TaskRecord, "closed_at_s" | "held" | "held_by" | "held_s" | "kind" | "promised_at_s" | "state">;

export function Result({ task }: { task: Ended }) {
  if (task.state !== "delivered" || task.closed_at_s === null || task.promised_at_s === null) return null;
  const speed = world.value?.factory.speed ?? 1;
  const lateS = (task.closed_at_s - task.promised_at_s) * speed;
  if (Math.abs(lateS) < PUNCTUAL_S) return <span>{t("tasks.onTime")}</span>;
  const by = factoryTime(Math.abs(lateS), speed);
  if (lateS > 0) return <><span class="tone-warn">{t("tasks.broken", { by })}</span><Cause task={task} /></>;
  return <span>{t("tasks.kept", { by })}</span>;
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
