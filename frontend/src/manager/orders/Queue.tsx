/**
 * The queue of open orders: dragged by its rows, or moved by a button. What a move costs whom is said before it is saved.
 * Agents are told another time; nobody's queue is edited.
 */
import { signal } from "@preact/signals";
import { changeOrder, fetchOrder } from "../../api/client";
import type { OrderView } from "../../api/types";
import { t } from "../../text/manager";
import { problemText } from "../problem-text";

/** Why the last move was refused; empty for none. */
export const queueFailed = signal("");
/** Which order is to stand before which; nothing is sent by that. */
export const proposed = signal<{ readonly order: string; readonly before: string } | null>(null);
export const moving = signal(false);
/** The row that is being dragged, and the one over which it is. */
const held = signal("");
const over = signal("");

export function isQueued(order: OrderView | undefined): order is OrderView {
  return typeof order?.wanted_at_s === "number" && ["released", "in_production", "in_delivery"].includes(order.status);
}

export function propose(order: string, before: string): void {
  if (moving.value || order === before || order === "") return;
  queueFailed.value = "";
  proposed.value = { order, before };
}

/** Send what is proposed. */
export async function move(): Promise<void> {
  const wanted = proposed.value;
  if (wanted === null || moving.value) return;
  moving.value = true;
  try {
    const { etag } = await fetchOrder(wanted.order);
    await changeOrder(wanted.order, { before: wanted.before }, etag);
    queueFailed.value = "";
  } catch (error) {
    queueFailed.value = t("queue.failed", { reason: problemText(error) });
  } finally {
    moving.value = false;
    proposed.value = null;
  }
}

/** What makes a row of an order in work one that can be dragged, and before which others can be dropped. */
export function dragged(order: OrderView) {
  if (!isQueued(order)) return {};
  const isTarget = over.value === order.id && held.value !== order.id;
  return {
    draggable: true,
    class: isTarget || proposed.value?.before === order.id ? "drop-before" : proposed.value?.order === order.id ? "to-move" : "",
    onDragStart: (event: DragEvent) => {
      held.value = order.id;
      event.dataTransfer?.setData("text/plain", order.id);
    },
    onDragOver: (event: DragEvent) => {
      if (held.value === "") return;
      event.preventDefault();
      over.value = order.id;
    },
    onDragEnd: () => {
      held.value = over.value = "";
    },
    onDrop: (event: DragEvent) => {
      event.preventDefault();
      propose(held.value, order.id);
      held.value = over.value = "";
    },
  };
}

/** The same by keyboard: one place on. */
export function SoonerButton({ ahead, order }: { order: OrderView; ahead: OrderView | undefined }) {
  if (!isQueued(order) || !isQueued(ahead)) return null;
  const name = order.reference ?? order.id;
  return (
    <button type="button" class="button small" disabled={moving.value} aria-label={t("queue.soonerOf", { order: name })} onClick={() => { propose(order.id, ahead.id); }}>
      {t("queue.sooner")}
    </button>
  );
}
