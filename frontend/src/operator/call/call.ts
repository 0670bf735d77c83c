/** What is called for the own station. */
import { effect, signal } from "@preact/signals";
import { newKey } from "../../api/client";
import { callOff, callTransport, fetchTransports, type TransportAnswer } from "../../api/transports";
import { problemText } from "../problem-text";
import { station } from "../state";
import { type Choice, loadOf } from "./steps";

const EVERY_MS = 2_000;

/** More than are under way at one station. */
const MOST = 12;

export const calls = signal<readonly TransportAnswer[]>([]);
/** After the first touch, and before the second. */
export const choice = signal<Choice | null>(null);
export const busy = signal(false);
/** Why the last touch did nothing; empty when it did. */
export const failed = signal("");

export function choose(item: string, way: Choice["way"]): void {
  choice.value = { item, way, key: newKey() };
  failed.value = "";
}

/** The second touch. */
export async function send(lot: number, loads: number, urgent: boolean): Promise<void> {
  const chosen = choice.value;
  const place = station.value?.id;
  if (!chosen || place === undefined || busy.value) return;
  await doing(async () => {
    for (let load = 1; load <= loads; load++) {
      const { draft, key } = loadOf(chosen, place, lot, urgent, load);
      await callTransport(draft, key);
    }
    choice.value = null;
  });
}

let thingKey = { for: "", key: "" };

/** Something without master data is brought here or taken away; says whether it was called. The same, tried again after it failed, is called once. */
export async function sendThing(way: Choice["way"], thing: string, there: string, ability: string): Promise<boolean> {
  const place = station.value?.id;
  if (place === undefined || busy.value) return false;
  const ends = way === "bring" ? { from: there, to: place } : { from: place, to: there };
  const draft = { ...ends, thing, ability, priority: "normal" as const };
  const said = JSON.stringify(draft);
  if (thingKey.for !== said) thingKey = { for: said, key: newKey() };
  await doing(async () => {
    await callTransport(draft, thingKey.key);
    thingKey = { for: "", key: "" };
    choice.value = null;
  });
  return failed.value === "";
}

export async function withdraw(transport: string): Promise<void> {
  await doing(() => callOff(transport));
}

async function doing(act: () => Promise<unknown>): Promise<void> {
  busy.value = true;
  failed.value = "";
  try {
    await act();
    await look();
  } catch (error) {
    failed.value = problemText(error);
  } finally {
    busy.value = false;
  }
}

async function look(): Promise<void> {
  const place = station.peek()?.id;
  if (place === undefined) return;
  try {
    calls.value = await fetchTransports(place, MOST);
  } catch {
    // What was known stays; the bar above says that the connection is gone.
  }
}

/** Follows what is called for the station, as long as its card is there. */
export function followCalls(): () => void {
  let timer: ReturnType<typeof setInterval> | undefined;
  const stop = effect(() => {
    clearInterval(timer);
    calls.value = [];
    if (!station.value) return;
    void look();
    timer = setInterval(() => void look(), EVERY_MS);
  });
  return () => {
    stop();
    clearInterval(timer);
  };
}
