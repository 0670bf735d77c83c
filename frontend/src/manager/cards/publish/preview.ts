/** What the order that is being written would need, as the gateway sees it now. */
import { effect, signal } from "@preact/signals";
import { previewOrder } from "../../../api/client";
import type { OrderPreview } from "../../../api/types";
import { nowS } from "../../../stream/stream";
import { checkDraft, type Draft, orderOf } from "./draft";
import { draft } from "./form";

/** A person is still typing. */
const PAUSE_MS = 300;
/** Machines work on, and others order. */
const AGAIN_MS = 15_000;

/** Null while nothing can be asked, or nobody answers: what the plant's file says is shown then. */
export const preview = signal<OrderPreview | null>(null);

/** Asks whenever the order changes, for as long as the card is shown; returns how to end that. */
export function followDraft(): () => void {
  let timer: ReturnType<typeof setTimeout> | undefined;
  let asked = 0;
  const ask = async (order: Draft): Promise<void> => {
    const mine = ++asked;
    const answer = await previewOrder(workOf(order)).catch(() => null);
    if (mine !== asked) return;
    preview.value = answer;
    timer = setTimeout(() => void ask(order), AGAIN_MS);
  };
  const stop = effect(() => {
    const order = draft.value;
    clearTimeout(timer);
    asked += 1;
    if (isAskable(order, nowS.peek())) timer = setTimeout(() => void ask(order), PAUSE_MS);
    else preview.value = null;
  });
  return () => {
    stop();
    clearTimeout(timer);
    asked += 1;
  };
}

function workOf(order: Draft): Parameters<typeof previewOrder>[0] {
  const { due_at, items } = orderOf(order, false);
  return due_at === undefined ? { items } : { items, due_at };
}

/** For whom it is does not matter yet. */
export function isAskable(order: Draft, nowS: number): boolean {
  const { due, product, quantity } = checkDraft(order, nowS);
  return order.product !== "" && !product && !quantity && !due;
}
