import { computed, useComputed } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { fetchOrders } from "../../../api/client";
import type { OrderView } from "../../../api/types";
import { Table } from "../../../parts/Table";
import { nowS, world } from "../../../stream/stream";
import { speakAlso } from "../../../text/speech";
import { format, t, tables, word } from "../../../text/views/order";
import { AskedChoice, AskedDay, AskedOnly, AskedWords } from "../../parts/filters/Asked";
import { CsvLink } from "../../parts/filters/CsvLink";
import { Pages } from "../../parts/pages/Pages";
import { PrintButton } from "../../parts/paper/PrintButton";
import { countOf, sortBy, usePaged } from "../../parts/pages/paged";
import { names, plant } from "../../state";
import { addressOf, asked } from "../../views";
import { queryOf, STATUSES, tableOf } from "../filter";
import { DueText } from "../DueText";
import { ImportButton, ImportDialog } from "../ImportDialog";
import { OrderActions } from "../OrderActions";
import { OrderProgress } from "../OrderProgress";
import { inOrder, isClosed, stateOf } from "../progress";
import { dragged, proposed, queueFailed, SoonerButton } from "../Queue";
import { WaitsText } from "../WaitsText";
import { BulkBar } from "./BulkBar";
import { forget, tick, ticked } from "./bulk";
import { MoveBar } from "./MoveBar";

/** By which a column is sorted; the others are not. */
const SORTED = ["", "reference", "customer", "", "", "", "due", ""] as const;

/** The one that was placed last: the list is read anew when there is another. */
const newest = computed(() => [...(world.value?.orders.keys() ?? [])].sort().at(-1) ?? "");

/** The list, once it has its words. */
export async function load(): Promise<typeof OrdersList> {
  await speakAlso(tables);
  return OrdersList;
}

/** All orders there ever were, as the address asks for them; what the stream tells of them is newer than the page. */
export function OrdersList() {
  const { again, failed, page, printing } = usePaged(async (said, place) => await fetchOrders({ ...queryOf(said), ...place }), newest);
  useEffect(() => () => {
    forget();
    proposed.value = null;
  }, []);
  const orders = useComputed(() => {
    const shown = (page.value?.items ?? []).map((order): OrderView => world.value?.orders.get(order.id) ?? order);
    // Who was moved in the queue stands there at once, and not when the page is read again.
    return (asked.value.sort ?? "") === "" ? inOrder(shown) : shown;
  }).value;
  const heads = [
    t("bulk.tick"),
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
      busy={page.value === null && failed.value === null}
      empty={emptyText(page.value === null, failed.value)}
      {...countOf(page.value)}
      sorting={{
        column: SORTED.findIndex((name) => name !== "" && name === asked.value.sort),
        descending: asked.value.down === "yes",
        by: (column) => { sortBy(SORTED[column] ?? ""); },
        can: (column) => SORTED[column] !== "",
      }}
      aside={
        <>
          <Filters />
          <PrintButton of={printing} />
          <a class="button" href="#recurring">
            {t("orders.recurring")}
          </a>
          <ImportButton />
        </>
      }
      below={
        <>
          {queueFailed.value !== "" && (
            <p class="complaint" role="alert">
              {queueFailed.value}
            </p>
          )}
          <MoveBar />
          <BulkBar orders={orders} onDone={again} />
          <Pages next={page.value?.next_cursor ?? null} />
          <ImportDialog />
        </>
      }
    >
      {orders.map((order, place) => (
        <Row key={order.id} order={order} ahead={orders[place - 1]} />
      ))}
    </Table>
  );
}

function emptyText(isLoading: boolean, failed: string | null): string {
  if (failed !== null) return t("list.failed", { reason: failed });
  if (isLoading) return t("view.loading");
  return t(Object.values(asked.value).some((said) => said !== "") ? "filter.none" : "orders.none");
}

function Filters() {
  const statuses = [
    { id: "open", name: t("filter.open") },
    // Planned ones are no status of their own.
    ...STATUSES.map((id) => ({ id, name: id === "in_production" ? t("filter.inProduction") : word("order", id) })),
  ];
  return (
    <>
      <AskedWords />
      <AskedChoice name="status" label={t("orders.status")} options={statuses} />
      <AskedChoice name="product" label={t("publish.product")} options={plant.value?.products ?? []} />
      <AskedDay name="since" label={t("list.since")} />
      <AskedDay name="until" label={t("list.until")} />
      <AskedOnly name="late" label={t("orders.late")} />
      <CsvLink href={tableOf(asked.value)} />
    </>
  );
}

function Row({ ahead, order }: { order: OrderView; ahead: OrderView | undefined }) {
  const items = order.items.map((item) => `${format.count(item.quantity)} ${names.value(item.product)}`);
  const name = order.reference ?? order.id;
  // Sorted otherwise, who stands before whom says nothing of the queue.
  const inQueue = (asked.value.sort ?? "") === "";
  return (
    <tr {...(inQueue ? dragged(order) : {})}>
      <td>
        {!isClosed(order) && (
          <label class="tick">
            <input
              type="checkbox"
              aria-label={t("bulk.tickOf", { order: name })}
              checked={ticked.value.has(order.id)}
              onChange={(event) => {
                tick(order.id, event.currentTarget.checked);
              }}
            />
          </label>
        )}
      </td>
      <th scope="row">
        <a class="link" draggable={false} href={addressOf(order.id)}>
          {name}
        </a>
      </th>
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
          <small class="muted line">{t("orders.deliveredAt", { at: format.when(order.delivered_at_s, nowS.value) })}</small>
        )}
      </td>
      <td>
        <div class="order-actions">
          <OrderActions order={order} all />
          {inQueue && <SoonerButton order={order} ahead={ahead} />}
        </div>
      </td>
    </tr>
  );
}
