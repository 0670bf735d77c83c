/** Whether so many vehicles are there that the map leaves out lines of those that are not chosen. */
import { computed } from "@preact/signals";
import { world } from "../../stream/stream";
import { LINES_MOST } from "../draw/detail";

export const isCrowded = computed(() => (world.value?.atvs.size ?? 0) > LINES_MOST);
