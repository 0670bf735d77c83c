import type { OrderView } from "../../api/types";
import { Tag } from "../../parts/Tag";
import { word } from "../../text/manager";

/** A priority other than the usual one. */
export function PriorityTag({ order }: { order: OrderView }) {
  if (order.priority === "normal") return null;
  return <Tag tone={order.priority === "urgent" ? "warn" : "normal"}>{word("priority", order.priority)}</Tag>;
}
