/** What all parts of the management panel share. */
import { computed, signal } from "@preact/signals";
import type { PlantFile } from "../api/types";
import { nowS, world } from "../stream/stream";
import { alertsOf } from "./alerts/alerts";
import { namesOf } from "../plant/names";

export const plant = signal<PlantFile | null>(null);
export const plantFailed = signal<string | null>(null);

export const alerts = computed(() => (world.value ? alertsOf(world.value, nowS.value) : []));
/** Names of materials and products by id. */
export const names = computed(() => namesOf(plant.value));
