/** Cards that have come to their place just now: touches on them do not count yet, and that is to be seen. */
import { signal } from "@preact/signals";
import { SETTLE_MS } from "../stop/places";

/** Vehicles, with the moment at which their card moved last. */
const moved = signal<ReadonlyMap<string, number>>(new Map());

/** Whether touches on the card of a vehicle do not count: as long as it shows that. */
export function isSettling(id: string): boolean {
  return moved.value.has(id);
}

/** The cards of these have moved. */
export function settle(ids: readonly string[]): void {
  if (ids.length === 0) return;
  const atMs = performance.now();
  moved.value = new Map([...moved.peek(), ...ids.map((id) => [id, atMs] as const)]);
  setTimeout(() => {
    // One that has moved once more has a timer of its own.
    moved.value = new Map([...moved.peek()].filter(([id, sinceMs]) => sinceMs !== atMs || !ids.includes(id)));
  }, SETTLE_MS);
}
