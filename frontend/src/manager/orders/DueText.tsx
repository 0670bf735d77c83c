import type { OrderView } from "../../api/types";
import { Tag } from "../../parts/Tag";
import { nowS } from "../../stream/stream";
import { format, t } from "../../text/manager";
import { PriorityTag } from "./PriorityTag";
import { isLate } from "./progress";

/** When an order is due, and whether that has passed; `bare` where a heading says already what it is. */
export function DueText({ order, bare = false }: { order: OrderView; bare?: boolean }) {
  if (order.due_at_s === null) {
    return (
      <span class="due muted">
        {t("orders.noDue")}
        <PriorityTag order={order} />
      </span>
    );
  }
  const due = format.due(order.due_at_s, nowS.value);
  return (
    <span class="due">
      {bare ? due : t("orders.due", { due })}
      <PriorityTag order={order} />
      {isLate(order, nowS.value) && <Tag tone="warn">{t("orders.late")}</Tag>}
    </span>
  );
}
