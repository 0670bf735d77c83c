/** Transports that wait until somebody has looked. Pure. */
import type { TaskView } from "../../api/types";
import { isHeld } from "../../parts/held-task";

/** Those whose loads are perhaps there and not counted, or at whose docks vehicles fail, the oldest first. */
export function heldOf(tasks: Iterable<TaskView>): readonly TaskView[] {
  return [...tasks].filter(isHeld).sort((a, b) => a.opened_at_s - b.opened_at_s || a.id.localeCompare(b.id));
}
