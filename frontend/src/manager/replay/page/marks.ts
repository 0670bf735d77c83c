/** Marks in words. */
import { format, word } from "../../../text/views/replay";
import { orderName } from "../../state";
import type { Mark } from "./film";

export function markText(mark: Mark): string {
  return `${leadText(mark)}${mark.order === "" ? "" : orderName(mark.order)}`;
}

/** What stands before the name of its order; all of it where there is none. */
export function leadText({ agent, at_s: atS, kind, order, other }: Mark): string {
  const whom = [agent, other].filter((each) => each !== "").join(", ");
  const what = `${format.clock(atS)} ${word("mark", kind)}`;
  if (order === "") return whom === "" ? what : `${what}: ${whom}`;
  return whom === "" ? `${what}: ` : `${what}: ${whom}, `;
}
