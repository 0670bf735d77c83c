/** The plant file, for pages that may be there before the gateway is, and that show a plant that people change. */
import { batch, effect, type ReadonlySignal, type Signal } from "@preact/signals";
import { fetchPlant } from "../api/client";
import type { PlantFile } from "../api/types";
import { callPlacesAs } from "../text/place";

/** Often enough for whoever waits in front of an empty page. */
const RETRY_MS = 3000;

/** Several changes in a row are one for a panel. */
export const PAUSE_MS = 500;
/** Each panel asks at some moment within it: two hundred of them do not ask at once. */
export const SPREAD_MS = 3500;

/** What asks for the plant, and keeps the newest answer. */
export interface PlantLoading {
  /** `plant_at_s` of the plant that is there; null where it was not told. */
  readonly atS: ReadonlySignal<number | null>;
  /** Asks now, and once more if it is asked for meanwhile; until an answer comes. */
  now(): Promise<void>;
  /** Asks within some seconds, however often it is called until then. */
  soon(): void;
}

/**
 * One request at a time: an older answer cannot overtake a newer one.
 *
 * @param failed says meanwhile, in `problemText`'s words, why the plant is not there
 * @param chance of what is equally likely between 0 and 1
 */
export function plantLoading(
  plant: Signal<PlantFile | null>,
  failed: Signal<string | null>,
  atS: Signal<number | null>,
  problemText: (error: unknown) => string,
  chance: () => number = Math.random,
): PlantLoading {
  let asking: Promise<void> | null = null;
  /** Counts how often it was asked for. */
  let wanted = 0;
  let timer: ReturnType<typeof setTimeout> | undefined;

  const later = (ms: number): void => {
    timer ??= setTimeout(() => void now(), ms);
  };
  const ask = async (): Promise<void> => {
    try {
      for (let answered = -1; answered !== wanted; ) {
        answered = wanted;
        const loaded = await fetchPlant();
        batch(() => {
          callPlacesAs(loaded.plant);
          plant.value = loaded.plant;
          atS.value = loaded.atS;
          failed.value = null;
        });
      }
    } catch (error) {
      failed.value = problemText(error);
      later(RETRY_MS);
    } finally {
      asking = null;
    }
  };
  const now = (): Promise<void> => {
    clearTimeout(timer);
    timer = undefined;
    wanted += 1;
    return (asking ??= ask());
  };
  return {
    atS,
    now,
    soon: () => {
      later(PAUSE_MS + chance() * SPREAD_MS);
    },
  };
}

/**
 * Asks for the plant anew when the stream tells of another one than is there. Once for each that is told of: the plant
 * may have come from another gateway, which tells another time.
 */
export function followChanges(
  world: ReadonlySignal<{ readonly factory: { readonly plant_at_s?: number | null } } | null>,
  plant: ReadonlySignal<PlantFile | null>,
  loading: Pick<PlantLoading, "atS" | "soon">,
): () => void {
  let askedFor: number | null = null;
  return effect(() => {
    const told = world.value?.factory.plant_at_s ?? null;
    // As long as there is none, it is asked for anyway.
    if (plant.value === null || told === null || told === loading.atS.value || told === askedFor) return;
    askedFor = told;
    loading.soon();
  });
}
