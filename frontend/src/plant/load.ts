/** The plant file, for pages that may be there before the gateway is. */
import type { Signal } from "@preact/signals";
import { fetchPlant } from "../api/client";
import type { PlantFile } from "../api/types";

/** Often enough for whoever waits in front of an empty page. */
const RETRY_MS = 3000;

/** Asks until the plant is there; `failed` says meanwhile, in `problemText`'s words, why it is not. */
export async function loadPlant(
  plant: Signal<PlantFile | null>,
  failed: Signal<string | null>,
  problemText: (error: unknown) => string,
): Promise<void> {
  try {
    plant.value = await fetchPlant();
    failed.value = null;
  } catch (error) {
    failed.value = problemText(error);
    setTimeout(() => void loadPlant(plant, failed, problemText), RETRY_MS);
  }
}
