import type { OrderView } from "../../api/types";
import { Tag } from "../../parts/Tag";
import { nowS } from "../../stream/stream";
import { format, t } from "../../text";
import { isLate } from "../alerts/alerts";

/** When an order is due, and whether that has passed. */
export function DueText({ order }: { order: OrderView }) {
  if (order.due_at_s === null) return <span class="muted">{t("orders.noDue")}</span>;
  return (
    <span class="due">
      {t("orders.due", { due: format.due(order.due_at_s, nowS.value) })}
      {isLate(order, nowS.value) && <Tag tone="warn">{t("orders.late")}</Tag>}
    </span>
  );
}
