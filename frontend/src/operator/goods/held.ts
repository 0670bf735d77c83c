/** Transports that wait until somebody has looked for their loads. Pure. */
import type { TaskView } from "../../api/types";

/** Those whose loads are perhaps there and not counted, the oldest first. */
export function heldOf(tasks: Iterable<TaskView>): readonly TaskView[] {
  return [...tasks].filter(isHeld).sort((a, b) => a.opened_at_s - b.opened_at_s || a.id.localeCompare(b.id));
}

/** Whether a person is to look for its load. */
export function isHeld({ trouble }: Pick<TaskView, "trouble">): boolean {
  return trouble?.reason === "disputed";
}
