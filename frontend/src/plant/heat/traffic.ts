/** The traffic of a period, asked for as long as somebody looks at it. */
import { effect, signal } from "@preact/signals";
import { askAgain } from "../../api/ask-again";
import { fetchTraffic } from "../../api/client";
import { type Heat, heatOf, type Measure } from "./heat";
import { layers } from "../controls/layers";

/** An hour changes little in ten seconds. */
const ASK_EVERY_MS = 10_000;

/** In milliseconds of the wall clock; the last hour is one of the factory's own time, for which the gateway needs no beginning. */
export const PERIODS = { hour: null, day: 86_400_000, week: 7 * 86_400_000 } as const;
export type Period = keyof typeof PERIODS;

/** What the reader wants to see. */
export const measure = signal<Measure>("passes");
export const period = signal<Period>("hour");

/** Null while nobody wants to see it, or nothing is known. */
export const heat = signal<Heat | null>(null);

/** Returns how to stop. */
export function followTraffic(): () => void {
  return effect(() => {
    if (!layers.value.heat) {
      heat.value = null;
      return undefined;
    }
    const [what, sinceMs] = [measure.value, PERIODS[period.value]];
    const since = (): string | undefined => (sinceMs === null ? undefined : new Date(Date.now() - sinceMs).toISOString());
    return askAgain(() => fetchTraffic(since()), (items) => { heat.value = heatOf(items, what); }, ASK_EVERY_MS);
  });
}
