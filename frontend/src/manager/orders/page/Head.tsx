import type { ComponentChildren } from "preact";
import type { OrderView } from "../../../api/types";
import { Meter } from "../../../parts/Meter";
import { Tag } from "../../../parts/Tag";
import { choose } from "../../../selection/selection";
import { nowS } from "../../../stream/stream";
import { format, t, word } from "../../../text/views/order";
import { printPage } from "../../parts/paper/printing";
import { names } from "../../state";
import { go } from "../../views";
import { OrderActions } from "../OrderActions";
import { PriorityTag } from "../PriorityTag";
import { isClosed, isLate, progressOf, stateOf } from "../progress";
import type { Story } from "./lanes";
import { loadOf } from "./moments";

/** Answers first what people come for: whether to worry. */
export function Head({ order, story }: { order: OrderView; story: Story }) {
  const { delivered, made, quantity } = progressOf(order);
  const each = (of: (item: OrderView["items"][number]) => number) =>
    format.list(order.items.filter((item) => of(item) > 0).map((item) => `${format.count(of(item))} ${names.value(item.product)}`));
  const counts = t("orders.progress", { delivered: format.count(delivered), made: format.count(made), quantity: format.count(quantity) });
  const arrived = story.transports.filter((transport) => transport.outcome === "delivered").length;
  const tookOver = story.moments.filter((moment) => moment.kind === "took_over").length;
  const sum = (n: number) => t("orders.counts", { delivered: format.count(n), quantity: format.count(quantity) });
  return (
    <section class="card order-head" aria-labelledby="order-title">
      <div class="order-title">
        <p class="muted">
          <a class="quiet-link" href="#orders">
            {t("orders.title")}
          </a>
          {order.reference !== null && ` / ${order.id}`}
        </p>
        <h1 id="order-title">{order.reference ?? order.id}</h1>
        <Tag tone={order.status === "cancelled" ? "warn" : "normal"}>{word("order", stateOf(order))}</Tag>
        <PriorityTag order={order} />
        <span class="muted">{order.customer}</span>
        <div class="order-deeds">
          <button type="button" class="button small" onClick={() => { choose({ kind: "order", id: order.id }); go("plant"); }}>
            {t("orderPage.show")}
          </button>
          <button type="button" class="button small" onClick={() => void printPage()}>
            {t("orderPage.print")}
          </button>
          <OrderActions order={order} all />
        </div>
      </div>
      <dl class="order-figures">
        <Figure head={t("orderPage.wanted")} more={isClosed(order) ? "" : format.list(order.items.map((item) => loadOf(item.product, item.quantity)))}>
          {t("orderPage.parts", { n: format.count(quantity) })}
        </Figure>
        <Figure head={t("orders.dueHead")} more={dueText(order)}>
          {order.due_at_s === null ? "–" : format.due(order.due_at_s, nowS.value)}
          {isLate(order, nowS.value) && <Tag tone="warn">{t("orders.late")}</Tag>}
        </Figure>
        <Expected order={order} story={story} />
        <Figure head={t("orderPage.made")} more={each((item) => item.made)}>
          {sum(made)}
        </Figure>
        <Figure head={t("orderPage.delivered")} more={each((item) => item.delivered)}>
          {sum(delivered)}
        </Figure>
        <Figure head={t("orderPage.transports")} more={tookOver > 0 ? t("orderPage.tookOver", { n: format.count(tookOver) }) : ""}>
          {t("orders.counts", { delivered: format.count(arrived), quantity: format.count(story.transports.length) })}
        </Figure>
      </dl>
      <Meter frac={delivered / quantity} behind={made / quantity} label={counts} tone="done" />
    </section>
  );
}

function Expected({ order, story }: { order: OrderView; story: Story }) {
  const { expected, late } = story;
  if (order.delivered_at_s !== null) {
    return <Figure head={t("orderPage.deliveredAt")}>{format.when(order.delivered_at_s, nowS.value)}</Figure>;
  }
  if (expected === null) return <Figure head={t("orderPage.expected")} more={t("orderPage.unknown")}>–</Figure>;
  const more = late === "" ? (order.due_at_s === null ? "" : t("orderPage.inTime")) : t(late === "yes" ? "orderPage.tooLate" : "orderPage.maybeLate");
  return (
    <Figure head={t("orderPage.expected")} more={more} warns={late !== ""}>
      {t("orderPage.range", { from: format.due(expected.from_at_s, nowS.value), to: format.due(expected.to_at_s, nowS.value) })}
    </Figure>
  );
}

function dueText(order: OrderView): string {
  if (order.due_at_s === null) return t("orders.noDue");
  if (isClosed(order)) return "";
  const leftS = order.due_at_s - nowS.value;
  return leftS >= 0 ? t("orderPage.dueIn", { time: format.duration(leftS) }) : t("orderPage.dueSince", { time: format.duration(-leftS) });
}

/** One figure of the head, with a line below it. */
export function Figure({ children, head, more = "", warns = false }: { head: string; more?: ComponentChildren; warns?: boolean; children: ComponentChildren }) {
  return (
    <div>
      <dt>{head}</dt>
      <dd>
        <b>{children}</b>
        {more !== "" && <small class={warns ? "tone-warn" : "muted"}>{more}</small>}
      </dd>
    </div>
  );
}
