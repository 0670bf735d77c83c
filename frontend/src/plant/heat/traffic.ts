/** The traffic of the last hour, asked for as long as somebody looks at it. */
import { effect, signal } from "@preact/signals";
import { fetchTraffic } from "../../api/client";
import { type Heat, heatOf } from "./heat";
import { layers } from "../controls/layers";

/** An hour changes little in ten seconds. */
const ASK_EVERY_MS = 10_000;

/** Null while nobody wants to see it, or nothing is known. */
export const heat = signal<Heat | null>(null);

/** Returns how to stop. */
export function followTraffic(): () => void {
  return effect(() => {
    if (!layers.value.heat) {
      heat.value = null;
      return undefined;
    }
    let wanted = true;
    const ask = async (): Promise<void> => {
      const items = await fetchTraffic().catch(() => null);
      // What was known stays until something newer is: a picture that goes away says less.
      if (wanted && items !== null) heat.value = heatOf(items);
    };
    void ask();
    const timer = setInterval(() => void ask(), ASK_EVERY_MS);
    return () => {
      wanted = false;
      clearInterval(timer);
    };
  });
}
