/** Marks in words. */
import { format, word } from "../../../text/views/replay";
import { orderName } from "../../state";
import type { Mark } from "./film";

export function markText(mark: Mark): string {
  const order = mark.order === "" ? "" : orderName(mark.order);
  const whom = [mark.agent, mark.other, order].filter((each) => each !== "").join(", ");
  return `${format.clock(mark.at_s)} ${word("mark", mark.kind)}${whom === "" ? "" : `: ${whom}`}`;
}
