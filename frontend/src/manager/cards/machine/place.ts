/** Places that are no machines, in one shape. */
import type { PlantFile } from "../../../api/types";
import { GATE } from "../../../plant/places";

export interface PlaceInfo {
  readonly id: string;
  readonly name: string;
  readonly kind: "storage" | "source" | "delivery" | "charger";
  readonly stocks: readonly { material: string; capacity: number }[];
}

export function placeOf(plant: PlantFile, id: string): PlaceInfo | null {
  const storage = plant.storages.find((each) => each.id === id);
  if (storage) return { id, name: storage.name, kind: "storage", stocks: storage.stocks };
  const warehouse = plant.warehouses.find((each) => each.id === id || (id === GATE && each.kind === "delivery"));
  if (warehouse) return { id: warehouse.id, name: warehouse.name, kind: warehouse.kind, stocks: warehouse.stocks };
  if (plant.chargers.some((each) => each.id === id)) return { id, name: id, kind: "charger", stocks: [] };
  return null;
}
