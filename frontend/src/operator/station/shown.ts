import { computed } from "@preact/signals";
import { selection } from "../../selection/selection";
import { plant, station } from "../state";

/** The machine that was touched on the map, else the one at which this person works. */
export const shown = computed(() => {
  const touched = selection.value.place;
  return plant.value?.machines.find(({ id }) => id === touched?.id) ?? station.value;
});
