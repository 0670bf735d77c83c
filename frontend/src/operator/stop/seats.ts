/** The Stop bar as it is now: who has which place, and which of them do not count touches yet. */
import { computed, signal } from "@preact/signals";
import { byId } from "../../plant/places";
import { tickMs, world } from "../../stream/stream";
import { openStops } from "./open";
import { type Place, seated, settlesInMs } from "./places";

export const places = signal<readonly Place[]>([]);

/** How many places can be seen at once; the bar says so when it has been measured. */
export const inSight = signal(Infinity);

/** When the whole bar has moved last, by a person's choice or a turned tablet. */
const movedAtMs = signal(-Infinity);
/** Moves on when the last of them has settled. */
const lookedAtMs = signal(-Infinity);

const present = computed(() => [...(world.value?.atvs.values() ?? [])].sort(byId).map(({ id }) => id));

/** Seat whoever has come: an effect of who is near, of how many places are in sight, and of time, by which a place is given up. */
export function seat(): void {
  if (world.value === null) return;
  const before = places.peek();
  const nowMs = Math.max(tickMs.value, performance.now());
  places.value = seated(before, present.value, new Set(openStops.value.keys()), inSight.value, nowMs);
  if (places.value !== before) lookWhenSettled();
}

/** What stands under a hand is something else now. */
export function moved(): void {
  movedAtMs.value = performance.now();
  lookWhenSettled();
}

/** Whether touches on a place do not count yet. */
export function isSettling(place: Place): boolean {
  return settlesInMs(place, movedAtMs.value, Math.max(lookedAtMs.value, performance.now())) > 0;
}

function lookWhenSettled(): void {
  const nowMs = performance.now();
  const leftMs = Math.max(0, ...places.peek().map((place) => settlesInMs(place, movedAtMs.peek(), nowMs)));
  if (leftMs > 0) setTimeout(() => (lookedAtMs.value = performance.now()), leftMs + 1);
}
