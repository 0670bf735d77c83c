/** Everything on the map that can be chosen, for the pointer and for the field Find. */
import type { AtvView, PlantFile } from "../api/types";
import type { Chosen } from "../selection/selection";
import type { Pickable } from "./surface/pick";

/** The agent of all delivery warehouses. */
export const GATE = "gate";

export function pickablesOf(plant: PlantFile): Pickable[] {
  const places = [...plant.storages, ...plant.warehouses, ...plant.chargers];
  return [
    ...plant.machines.map(({ box, id }) => ({ box, id, kind: "machine" as const })),
    ...places.map(({ box, id }) => ({ box, id, kind: "place" as const })),
  ];
}

export interface Findable {
  readonly chosen: Chosen;
  readonly id: string;
  readonly name: string;
}

export function findablesOf(plant: PlantFile, atvs: Iterable<AtvView>): Findable[] {
  const of = (kind: Chosen["kind"], id: string, name: string): Findable => ({ chosen: { kind, id }, id, name });
  return [
    ...[...atvs].map((atv) => of("atv", atv.id, "")).sort(byId),
    ...plant.machines.map(({ id, name }) => of("machine", id, name)).sort(byId),
    ...[...plant.storages, ...plant.warehouses].map(({ id, name }) => of("place", id, name)),
    ...plant.chargers.map(({ id }) => of("place", id, "")),
  ];
}

const numbers = new Intl.Collator("en", { numeric: true });

/** ATV2 before ATV10. */
export function byId(a: { id: string }, b: { id: string }): number {
  return numbers.compare(a.id, b.id);
}

/** Names that begin with the words come before those that only hold them. */
export function find(all: readonly Findable[], words: string, most: number): Findable[] {
  const wanted = words.trim().toLowerCase();
  const rank = ({ id, name }: Findable): number => {
    if (id.toLowerCase().startsWith(wanted)) return 0;
    return `${id} ${name}`.toLowerCase().includes(wanted) ? 1 : 2;
  };
  return all
    .map((each) => ({ each, rank: rank(each) }))
    .filter((scored) => scored.rank < 2)
    .sort((a, b) => a.rank - b.rank)
    .slice(0, most)
    .map(({ each }) => each);
}
