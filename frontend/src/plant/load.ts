/** The plant file, for pages that may be there before the gateway is, and before some machines are. */
import { effect, type ReadonlySignal, type Signal } from "@preact/signals";
import { fetchPlant } from "../api/client";
import type { PlantFile } from "../api/types";
import { callPlacesAs } from "../text/place";

/** Often enough for whoever waits in front of an empty page. */
const RETRY_MS = 3000;

/** Asks until the plant is there; `failed` says meanwhile, in `problemText`'s words, why it is not. */
export async function loadPlant(
  plant: Signal<PlantFile | null>,
  failed: Signal<string | null>,
  problemText: (error: unknown) => string,
): Promise<void> {
  try {
    const loaded = await fetchPlant();
    callPlacesAs(loaded);
    plant.value = loaded;
    failed.value = null;
  } catch (error) {
    failed.value = problemText(error);
    setTimeout(() => void loadPlant(plant, failed, problemText), RETRY_MS);
  }
}

/**
 * Calls `ask` for the plant anew when a machine is heard of that it does not have: one that came to a running
 * factory. Once for each, since a machine that does not fit into the plant is in no plant file.
 */
export function followJoining(
  plant: ReadonlySignal<PlantFile | null>,
  world: ReadonlySignal<{ readonly machines: ReadonlyMap<string, unknown> } | null>,
  ask: () => void,
): () => void {
  const asked = new Set<string>();
  return effect(() => {
    if (!plant.value || !world.value) return;
    for (const { id } of plant.value.machines) asked.add(id);
    const strangers = [...world.value.machines.keys()].filter((id) => !asked.has(id));
    for (const id of strangers) asked.add(id);
    if (strangers.length > 0) ask();
  });
}

/** Calls `ask` for the plant anew when it has changed at the gateway, and when another gateway tells of it. */
export function followChanges(
  world: ReadonlySignal<{ readonly factory: { readonly plant_at_s?: number | null } } | null>,
  ask: () => void,
): () => void {
  let before: number | null = null;
  return effect(() => {
    const changedAtS = world.value?.factory.plant_at_s ?? null;
    if (changedAtS === null || changedAtS === before) return;
    const isFirst = before === null;
    before = changedAtS;
    if (!isFirst) ask();
  });
}
