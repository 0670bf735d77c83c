/** Names that people use for what agents know by id. */
import type { PlantFile } from "../api/types";

export type Names = (id: string) => string;

export function namesOf(plant: PlantFile | null): Names {
  const items = [...(plant?.materials ?? []), ...(plant?.products ?? [])];
  const names = new Map(items.map((item) => [item.id, item.name]));
  return (id) => names.get(id) ?? id;
}
