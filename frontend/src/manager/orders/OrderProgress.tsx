import type { OrderView } from "../../api/types";
import { Meter } from "../../parts/Meter";
import { format, t } from "../../text/manager";
import { progressOf } from "./progress";

/** Delivered before made before ordered, in one bar and in figures. */
export function OrderProgress({ order }: { order: OrderView }) {
  const { quantity, delivered } = progressOf(order);
  return (
    <span class="order-progress" title={progressText(order)}>
      <ProgressBar order={order} />
      <span class="num">
        {t("orders.counts", { delivered: format.count(delivered), quantity: format.count(quantity) })}
      </span>
    </span>
  );
}

/** The bar alone. */
export function ProgressBar({ order }: { order: OrderView }) {
  const { quantity, made, delivered } = progressOf(order);
  return <Meter frac={delivered / quantity} behind={made / quantity} label={progressText(order)} tone="done" />;
}

function progressText(order: OrderView): string {
  const { quantity, made, delivered } = progressOf(order);
  return t("orders.progress", {
    delivered: format.count(delivered),
    made: format.count(made),
    quantity: format.count(quantity),
  });
}
