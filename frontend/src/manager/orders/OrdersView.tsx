import { useComputed } from "@preact/signals";
import type { OrderView } from "../../api/types";
import { world } from "../../stream/stream";
import { format, t, word } from "../../text/manager";
import { Table } from "../../parts/Table";
import { names } from "../state";
import { DueText } from "./DueText";
import { OrderActions } from "./OrderActions";
import { OrderProgress } from "./OrderProgress";
import { inOrder, stateOf } from "./progress";
import { WaitsText } from "./WaitsText";

/** All orders that the stream holds: the open ones and the last that closed. */
export function OrdersView() {
  const orders = useComputed(() => inOrder(world.value?.orders.values() ?? [])).value;
  const heads = [
    t("orders.reference"),
    t("orders.customer"),
    t("orders.items"),
    t("orders.status"),
    t("orders.progressHead"),
    t("orders.dueHead"),
    t("orders.actions"),
  ];
  return (
    <Table
      title={t("orders.title")}
      heads={heads}
      empty={t("orders.none")}
      aside={
        <a class="button" href="/api/orders?format=csv" download title={t("orders.csvTitle")}>
          {t("orders.csv")}
        </a>
      }
    >
      {orders.map((order) => (
        <Row key={order.id} order={order} />
      ))}
    </Table>
  );
}

function Row({ order }: { order: OrderView }) {
  const items = order.items.map((item) => `${format.count(item.quantity)} ${names.value(item.product)}`);
  return (
    <tr>
      <th scope="row">{order.reference ?? order.id}</th>
      <td>{order.customer}</td>
      <td>{format.list(items)}</td>
      <td>
        {word("order", stateOf(order))}
        {order.waits !== "" && (
          <small class="line">
            <WaitsText order={order} />
          </small>
        )}
      </td>
      <td>
        <OrderProgress order={order} />
      </td>
      <td>
        <DueText order={order} bare />
        {order.delivered_at_s !== null && (
          <small class="muted line">{t("orders.deliveredAt", { at: format.clock(order.delivered_at_s) })}</small>
        )}
      </td>
      <td>
        <OrderActions order={order} all />
      </td>
    </tr>
  );
}
