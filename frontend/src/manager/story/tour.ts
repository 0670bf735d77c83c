/** Three steps for who comes for the first time: until they were seen or skipped in this browser, and again by the menu. */
import { signal } from "@preact/signals";
import { recall, remember } from "../../memory";

export const STEPS = 3;
const KEY = "dray.tour.1";

/** The step that is shown, from 1; 0 for none. */
export const step = signal(recall(KEY) === null ? 1 : 0);

export function goOn(): void {
  if (step.value < STEPS) step.value += 1;
  else skip();
}

export function skip(): void {
  step.value = 0;
  remember(KEY, "seen");
}

export function begin(): void {
  step.value = 1;
}
