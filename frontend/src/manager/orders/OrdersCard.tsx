import { useComputed } from "@preact/signals";
import type { OrderView } from "../../api/types";
import { Card } from "../../parts/Card";
import { world } from "../../stream/stream";
import { format, n, t, word } from "../../text/manager";
import { names } from "../state";
import { addressOf } from "../views";
import { DueText } from "./DueText";
import { OrderActions } from "./OrderActions";
import { ProgressBar } from "./OrderProgress";
import { inOrder, isClosed, progressOf, stateOf } from "./progress";
import { WaitsText } from "./WaitsText";

/** The card holds the open ones and the last that closed; the view Orders has them all. */
const MOST = 30;

export function OrdersCard() {
  const orders = useComputed(() => inOrder(world.value?.orders.values() ?? [])).value;
  const open = orders.filter((order) => !isClosed(order)).length;
  return (
    <Card
      title={t("orders.title")}
      aside={<a href="#orders" class="quiet-link">{n("orders.open", open)}</a>}
      class="orders"
      scrolls
    >
      {orders.length === 0 && <p class="empty">{t("orders.none")}</p>}
      <ul class="order-list">
        {orders.slice(0, MOST).map((order) => (
          <OrderRow key={order.id} order={order} />
        ))}
      </ul>
    </Card>
  );
}

function OrderRow({ order }: { order: OrderView }) {
  const what = order.items.map((item) => names.value(item.product)).join(", ");
  const from = [order.reference, order.customer].filter(Boolean).join(" · ");
  const { delivered, quantity } = progressOf(order);
  return (
    <li class={`order ${isClosed(order) ? "closed" : ""}`}>
      <div class="order-line">
        <a class="link" href={addressOf(order.id)}>
          {what}
        </a>
        <span class="order-status">{word("order", stateOf(order))}</span>
      </div>
      <div class="order-line small muted">
        <span class="clip" title={from}>{from}</span>
        <span class="num">{t("orders.counts", { delivered: format.count(delivered), quantity: format.count(quantity) })}</span>
        {order.waits !== null ? <WaitsText waits={order.waits} /> : order.status === "stored" ? <OrderActions order={order} /> : <DueText order={order} />}
      </div>
      <ProgressBar order={order} />
    </li>
  );
}
