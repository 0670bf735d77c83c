import type { OrderView } from "../../api/types";
import { Meter } from "../../parts/Meter";
import { format, t } from "../../text/manager";
import { progressOf } from "./progress";

/** Delivered before made before ordered, in one bar. */
export function OrderProgress({ order }: { order: OrderView }) {
  const { quantity, made, delivered } = progressOf(order);
  const label = t("orders.progress", {
    delivered: format.count(delivered),
    made: format.count(made),
    quantity: format.count(quantity),
  });
  return (
    <span class="order-progress" title={label}>
      <Meter frac={delivered / quantity} behind={made / quantity} label={label} tone="done" />
      <span class="num">
        {t("orders.counts", { delivered: format.count(delivered), quantity: format.count(quantity) })}
      </span>
    </span>
  );
}
