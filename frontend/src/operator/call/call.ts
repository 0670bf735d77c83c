/** What is called for the own station. */
import { computed, effect, signal } from "@preact/signals";
import { newKey } from "../../api/client";
import { callOff, callTransport, fetchTransports, type TransportAnswer } from "../../api/transports";
import { format, t } from "../../text/operator";
import { problemText } from "../problem-text";
import { names, station } from "../state";
import { shown } from "../station/shown";
import { type Choice, loadOf } from "./steps";

const EVERY_MS = 2_000;

/** More than are under way at one station. */
const MOST = 12;

/** The own station; for who works at none, the machine that was touched on the map. */
export const place = computed(() => station.value ?? shown.value);

const placeId = computed(() => place.value?.id);

export const calls = signal<readonly TransportAnswer[]>([]);
/** After the first touch, and before the second. */
export const choice = signal<Choice | null>(null);
export const busy = signal(false);
/** Why the last touch did nothing, as a sentence; empty when it did. */
export const failed = signal("");
/** What the last touch has called; empty after the next. */
export const sent = signal("");

export function choose(item: string, way: Choice["way"]): void {
  choice.value = { item, way, key: newKey() };
  failed.value = "";
  sent.value = "";
}

/** The second touch. */
export async function send(quantity: number, loads: number, urgent: boolean): Promise<void> {
  const chosen = choice.value;
  const at = placeId.value;
  if (!chosen || at === undefined || busy.value) return;
  await doing("calling.failed", async () => {
    for (let load = 1; load <= loads; load++) {
      const { draft, key } = loadOf(chosen, at, quantity, urgent, load);
      await callTransport(draft, key);
    }
    choice.value = null;
    sent.value = t("calling.sent", { what: `${format.count(quantity * loads)} ${names.value(chosen.item)}` });
  });
}

let thingKey = { for: "", key: "" };

/** Something without master data is brought here or taken away; says whether it was called. The same, tried again after it failed, is called once. */
export async function sendThing(way: Choice["way"], thing: string, there: string, ability: string): Promise<boolean> {
  const at = placeId.value;
  if (at === undefined || busy.value) return false;
  const ends = way === "bring" ? { from: there, to: at } : { from: at, to: there };
  const draft = { ...ends, thing, ability, priority: "normal" as const };
  const said = JSON.stringify(draft);
  if (thingKey.for !== said) thingKey = { for: said, key: newKey() };
  await doing("calling.failed", async () => {
    await callTransport(draft, thingKey.key);
    thingKey = { for: "", key: "" };
    choice.value = null;
    sent.value = t("calling.sent", { what: thing });
  });
  return failed.value === "";
}

export async function withdraw(transport: string): Promise<void> {
  await doing("calling.notOff", () => callOff(transport));
}

async function doing(otherwise: "calling.failed" | "calling.notOff", act: () => Promise<unknown>): Promise<void> {
  busy.value = true;
  failed.value = "";
  sent.value = "";
  try {
    await act();
    await look();
  } catch (error) {
    failed.value = t(otherwise, { reason: problemText(error) });
  } finally {
    busy.value = false;
  }
}

async function look(): Promise<void> {
  const at = placeId.peek();
  if (at === undefined) return;
  try {
    const found = await fetchTransports(at, MOST);
    if (placeId.peek() === at) calls.value = found;
  } catch {
    // What was known stays; the bar above says that the connection is gone.
  }
}

/** Follows what is called for the place, as long as its card is there. */
export function followCalls(): () => void {
  let timer: ReturnType<typeof setInterval> | undefined;
  const stop = effect(() => {
    clearInterval(timer);
    calls.value = [];
    choice.value = null;
    failed.value = "";
    sent.value = "";
    if (placeId.value === undefined) return;
    void look();
    timer = setInterval(() => void look(), EVERY_MS);
  });
  return () => {
    stop();
    clearInterval(timer);
  };
}
