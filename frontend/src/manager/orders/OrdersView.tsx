import { computed, signal, useComputed } from "@preact/signals";
import type { OrderView } from "../../api/types";
import { nowS, world } from "../../stream/stream";
import { format, t, word } from "../../text/manager";
import { Table } from "../../parts/Table";
import { Choice } from "../parts/filters/Choice";
import { CsvLink } from "../parts/filters/CsvLink";
import { Only } from "../parts/filters/Only";
import { Search } from "../parts/filters/Search";
import { names, plant } from "../state";
import { isWanted, STATUSES, tableOf, type Wanted } from "./filter";
import { DueText } from "./DueText";
import { ImportButton, ImportDialog } from "./ImportDialog";
import { OrderActions } from "./OrderActions";
import { OrderProgress } from "./OrderProgress";
import { inOrder, stateOf } from "./progress";
import { WaitsText } from "./WaitsText";

const words = signal("");
const status = signal("");
const product = signal("");
const late = signal(false);
const wanted = computed<Wanted>(() => ({ words: words.value, status: status.value, product: product.value, late: late.value }));

/** All orders that the stream holds: the open ones and the last that closed. */
export function OrdersView() {
  const orders = useComputed(() => inOrder(world.value?.orders.values() ?? [])).value;
  const shown = orders.filter((order) => isWanted(order, wanted.value, nowS.value, names.value));
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
      empty={t(orders.length === 0 ? "orders.none" : "filter.none")}
      aside={
        <>
          <Filters />
          <ImportButton />
        </>
      }
      below={<ImportDialog />}
    >
      {shown.map((order) => (
        <Row key={order.id} order={order} />
      ))}
    </Table>
  );
}

function Filters() {
  const statuses = [
    { id: "open", name: t("filter.open") },
    ...STATUSES.map((id) => ({ id, name: word("order", id) })),
  ];
  return (
    <>
      <Search words={words} />
      <Choice label={t("orders.status")} any={t("filter.any")} value={status.value} options={statuses} onChosen={(id) => (status.value = id)} />
      <Choice label={t("publish.product")} any={t("filter.any")} value={product.value} options={plant.value?.products ?? []} onChosen={(id) => (product.value = id)} />
      <Only label={t("orders.late")} wanted={late} />
      <CsvLink href={tableOf(wanted.value)} />
    </>
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
        {order.waits !== null && (
          <small class="line">
            <WaitsText waits={order.waits} />
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
