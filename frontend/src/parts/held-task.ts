/** Whether a transport waits until a person has looked. Pure. */
import type { TaskView } from "../api/types";

/** Its load is perhaps there and not counted, or vehicle after vehicle fails at a dock (`fails_at`). */
export function isHeld({ trouble }: Pick<TaskView, "trouble">): boolean {
  return trouble?.reason === "disputed" || trouble?.reason === "dock_fails";
}
