/** What people call a place: a warehouse by its name, as far as it lies in the areas that they see; a storage by its id, as the map does, and all others. */
import { signal } from "@preact/signals";
import type { PlantFile } from "../api/types";

const named = signal<ReadonlyMap<string, string>>(new Map());

/** From now on places are called as this plant calls them. */
export function callPlacesAs({ warehouses }: Pick<PlantFile, "warehouses">): void {
  named.value = new Map(warehouses.map(({ id, name }) => [id, name]));
}

export function placeOf(id: string): string {
  return named.value.get(id) ?? id;
}
