/** What all parts of the management panel share. */
import { computed, signal } from "@preact/signals";
import type { PlantFile } from "../api/types";
import { inOrder } from "../alerts/alerts";
import { world } from "../stream/stream";
import { namesOf } from "../plant/names";

export const plant = signal<PlantFile | null>(null);
export const plantFailed = signal<string | null>(null);

/** In the order in which they are answered. */
export const alerts = computed(() => inOrder(world.value?.alerts.values() ?? []));
/** Names of materials and products by id. */
export const names = computed(() => namesOf(plant.value));
