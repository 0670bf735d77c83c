/** What is chosen on an order's page stands in its address: it can be sent, and the browser goes back and forward over it. */
import { computed } from "@preact/signals";
import { ask, asked } from "../../views";
import type { Wanted } from "./moments";

/** Which events may be asked for. */
export const FILTERS = ["all", "transports", "problems"] as const satisfies readonly Wanted[];

/** The chosen transport's task; empty for none. */
export const chosenTransport = computed(() => asked.value.transport ?? "");

/** What an address asks for that nobody has written here is all of it. */
export const wantedEvents = computed<Wanted>(() => FILTERS.find((each) => each === asked.value.events) ?? "all");

/** @param task empty for none */
export function chooseTransport(task: string): void {
  ask({ transport: task });
}

export function wantEvents(wanted: Wanted): void {
  ask({ events: wanted === "all" ? "" : wanted });
}
