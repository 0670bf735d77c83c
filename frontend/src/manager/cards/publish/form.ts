/** The form's state, and the sending of it. */
import { computed, effect, signal } from "@preact/signals";
import { newKey, placeOrder } from "../../../api/client";
import type { FieldError } from "../../../api/types";
import { Problem } from "../../../api/problem";
import { afterSent } from "../../../parts/sent";
import { nowS } from "../../../stream/stream";
import { format, t } from "../../../text/manager";
import { HERE } from "../../parts/Linked";
import { problemText } from "../../problem-text";
import { plant } from "../../state";
import { checkDraft, chosenOf, type Complaint, type Draft, type Field, fieldOf, MOST_PIECES, orderOf, quantityOf } from "./draft";

const written = signal<Draft>({ product: "", quantity: "40", customer: "", reference: "", due: "", priority: "normal" });

/** The first product stands in the form until a person chooses another. It stays there when others are defined, which come first in the plant. */
effect(() => {
  const first = plant.value?.products[0]?.id ?? "";
  if (first !== "" && written.peek().product === "") written.value = { ...written.peek(), product: first };
});

export const draft = computed<Draft>(() => ({
  ...written.value,
  product: chosenOf(written.value.product, plant.value?.products ?? []),
}));
/** What was found wrong when it was sent, until that field is changed. */
const found = signal<Partial<Record<Field, string>>>({});
/** An impossible quantity is told at once: nothing can be foreseen for it. */
export const complaints = computed<Partial<Record<Field, string>>>(() => {
  const isImpossible = written.value.quantity.trim() !== "" && quantityOf(written.value) === null;
  return isImpossible ? { ...found.value, ...inWords({ quantity: "needQuantity" }) } : found.value;
});
export const sending = signal(false);
/** Where `HERE` stands in `text`, there is a link to `order`. */
export const outcome = signal<{ good: boolean; text: string; order?: string; hints?: readonly string[] } | null>(null);

/** One key per order, kept over failed tries; a changed order is another one. */
let key = newKey();
let keyFor = "";

export function edit(field: Field, value: string): void {
  written.value = { ...written.value, [field]: value };
  found.value = { ...found.value, [field]: undefined };
  outcome.value = null;
}

export async function send(release: boolean): Promise<void> {
  if (sending.value) return;
  outcome.value = null;
  found.value = inWords(checkDraft(draft.value, nowS.value));
  const firstWrong = Object.keys(found.value)[0];
  if (firstWrong !== undefined) {
    document.getElementById(`publish-${firstWrong}`)?.focus();
    return;
  }
  const { reference } = written.value;
  const order = orderOf(draft.value, release);
  const body = JSON.stringify(order);
  if (body !== keyFor) [key, keyFor] = [newKey(), body];
  sending.value = true;
  try {
    const { hints, id } = await placeOrder(order, key);
    keyFor = "";
    written.value = { ...written.value, reference: afterSent(reference, written.value.reference, "") };
    outcome.value = { good: true, text: t(release ? "publish.published" : "publish.defined", { id: HERE }), order: id, hints: await inReadersWords(hints) };
  } catch (error) {
    complain(error);
  } finally {
    sending.value = false;
  }
}

/** What is odd in an order that was placed all the same. */
async function inReadersWords(hints: readonly FieldError[]): Promise<string[]> {
  if (hints.length === 0) return [];
  const { faultText } = await import("../../../text/views/rows/fault-text");
  return await Promise.all(hints.map(faultText));
}

function complain(error: unknown): void {
  const atFields: Partial<Record<Field, string>> = {};
  const elsewhere: string[] = [];
  for (const each of error instanceof Problem ? error.errors : []) {
    const field = fieldOf(each);
    if (field) atFields[field] = each.reason;
    else elsewhere.push(`${each.field}: ${each.reason}`);
  }
  found.value = atFields;
  if (Object.keys(atFields).length > 0 && elsewhere.length === 0) return;
  const reason = elsewhere.join("; ") || problemText(error);
  outcome.value = { good: false, text: t("publish.failed", { reason }) };
}

function inWords(wrong: Partial<Record<Field, Complaint>>): Partial<Record<Field, string>> {
  const words: Record<Complaint, string> = {
    needProduct: t("publish.needProduct"),
    needQuantity: t("publish.needQuantity", { most: format.count(MOST_PIECES) }),
    needCustomer: t("publish.needCustomer"),
    needFuture: t("publish.needFuture"),
  };
  return Object.fromEntries(Object.entries(wrong).map(([field, complaint]) => [field, words[complaint]]));
}
