/** Whether this plant's vehicles drive with right of way, and the drawing of it, which is loaded then. */
import { computed } from "@preact/signals";
import { world } from "../../stream/stream";
import { hasTraffic } from "./held";

export const withTraffic = computed(() => hasTraffic(world.value?.atvs.values() ?? []));

export type Drawing = typeof import("./draw");

export function loadDrawing(): Promise<Drawing> {
  return import("./draw");
}
