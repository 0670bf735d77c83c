/** Which layers of the map are shown; remembered in this browser. */
import { effect, signal } from "@preact/signals";
import { recall, remember } from "../../memory";

export const LAYERS = ["ways", "traffic", "primary", "watch", "mesh", "all", "areas", "heat", "labels"] as const;
export type Layer = (typeof LAYERS)[number];
export type Layers = Readonly<Record<Layer, boolean>>;

/** With a number: who chose when there were fewer has not chosen against the new ones. */
const KEY = "dray.layers.3";
const FIRST: Layers = { ways: true, traffic: true, primary: true, watch: true, mesh: true, all: false, areas: false, heat: false, labels: true };

export const layers = signal<Layers>(layersFrom(recall(KEY)));

/**
 * @param traffic whether vehicles drive with right of way: without, nothing is in its layer
 * @param crowded whether there are so many vehicles that lines of everybody are a choice
 */
export function layersWith(traffic: boolean, crowded = false): readonly Layer[] {
  return LAYERS.filter((layer) => (layer !== "traffic" || traffic) && (layer !== "all" || crowded));
}

export function toggleLayer(layer: Layer): void {
  layers.value = { ...layers.value, [layer]: !layers.value[layer] };
}

effect(() => {
  remember(KEY, LAYERS.filter((layer) => layers.value[layer]).join(" "));
});

/** From the remembered names; without memory, what is useful at first sight. */
export function layersFrom(stored: string | null): Layers {
  if (stored === null) return FIRST;
  const on = new Set(stored.split(" "));
  return Object.fromEntries(LAYERS.map((layer) => [layer, on.has(layer)])) as Layers;
}
