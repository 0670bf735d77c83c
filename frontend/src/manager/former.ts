/** Names of products that were removed: orders that have ended still name them. Asked for when one is met. */
import { signal } from "@preact/signals";
import type { PlantFile } from "../api/types";
import type { Names } from "../plant/names";

/** After an answer that failed. Until then nothing is asked, however often names are wanted. */
export const PAUSE_MS = 10_000;

/** Of the products that were removed last: as many as the gateway tells of. */
const known = signal<Map<string, string>>(new Map());
/** Counts pauses that have ended: whoever has wanted a name meanwhile draws again, and so wants it again. */
const pauses = signal(0);
/** For this plant all of them were read: who has no name then has none as long as nothing is removed. */
let readFor: object | null = null;
/** For this plant a name is wanted that is not known. */
let wantedFor: object | null = null;
/** While an answer is waited for, and in the pause after one that failed. */
let isBusy = false;

interface Plant {
  readonly products: readonly Pick<PlantFile["products"][number], "id">[];
}

/**
 * What products were called that a plant does not have; their id where nobody knows it.
 *
 * @param plant another object whenever it has changed
 */
export function formerOf(plant: Plant | null): Names {
  if (plant === null) return (id) => id;
  // Defined anew: when they are removed once more they may have been called otherwise.
  for (const { id } of plant.products) known.peek().delete(id);
  return (id) => {
    const name = known.value.get(id);
    if (name === undefined && readFor !== plant) {
      pauses.value.valueOf();
      wantedFor = plant;
      // Not while something is drawn.
      if (!isBusy) queueMicrotask(() => void ask());
    }
    return name ?? id;
  };
}

async function ask(): Promise<void> {
  if (isBusy || wantedFor === null) return;
  isBusy = true;
  const plant = wantedFor;
  wantedFor = null;
  try {
    const { fetchDefinitions } = await import("../api/products");
    const found = await fetchDefinitions(true);
    readFor = plant;
    known.value = new Map(found.map(({ id, name }) => [id, name]));
    isBusy = false;
    // Another plant may have come while it was asked.
    answeredFor(plant);
    void ask();
  } catch {
    // Ids are shown, as they are of whatever nobody knows.
    setTimeout(() => {
      isBusy = false;
      wantedFor = null;
      pauses.value++;
    }, PAUSE_MS);
  }
}

/** What was wanted for this plant meanwhile has its answer. */
function answeredFor(plant: object): void {
  if (wantedFor === plant) wantedFor = null;
}
