/** What all parts of the management panel share. */
import { computed, signal } from "@preact/signals";
import { nameItemsBy } from "../api/problem-words";
import type { PlantFile } from "../api/types";
import { inOrder } from "../alerts/alerts";
import { world } from "../stream/stream";
import { namesOf } from "../plant/names";
import { formerOf } from "./former";
import { placeOf } from "../text/place";

export const plant = signal<PlantFile | null>(null);
export const plantFailed = signal<string | null>(null);

/** In the order in which they are answered. */
export const alerts = computed(() => inOrder(world.value?.alerts.values() ?? []));
/** Names of materials and products by id, also of removed ones. */
export const names = computed(() => namesOf(plant.value, formerOf(plant.value)));
nameItemsBy((id) => namesOf(plant.value)(id));

/** What people call an order: by its reference, as long as the stream has it. */
export const orderName = (order: string): string => world.value?.orders.get(order)?.reference ?? order;

/** What people call a task: a goal has the name of its order, of which its id begins with the id. */
export function taskName(id: string, order: string, called = orderName(order)): string {
  return order !== "" && id.startsWith(order) ? called + id.slice(order.length) : id;
}

export { placeOf };

/** What people call an area of the floor. */
export function areaName(id: string): string {
  return plant.value?.areas.find((each) => each.id === id)?.name ?? id;
}

/** Of a source that is not chosen yet all that may be it, which have "/" between them. */
export function placesOf(ids: string): string {
  return ids.split("/").map(placeOf).join(" / ");
}
