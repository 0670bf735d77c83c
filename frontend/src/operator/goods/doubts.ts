/** Loads of which nobody can tell whether they lie at a place: somebody counts. Pure. */
import type { DoubtView, MachineView, StationView } from "../../api/types";

/** A doubtful load at a place. */
export interface Doubt extends DoubtView {
  readonly place: string;
  /** At a station; else at a machine. */
  readonly station: boolean;
  /** Pieces of the item in the stock. */
  readonly level: number;
}

interface Places {
  readonly machines: ReadonlyMap<string, Pick<MachineView, "id" | "doubts" | "buffers" | "goods">>;
  readonly stations: ReadonlyMap<string, Pick<StationView, "id" | "doubts" | "stocks">>;
}

/** All of them, by place. */
export function doubtsOf({ machines, stations }: Places): readonly Doubt[] {
  return [
    ...[...machines.values()].flatMap(({ buffers, doubts, goods, id }) => at(id, false, doubts, [...buffers, ...goods])),
    ...[...stations.values()].flatMap(({ doubts, id, stocks }) => at(id, true, doubts, stocks)),
  ].sort((a, b) => a.place.localeCompare(b.place) || a.load.localeCompare(b.load));
}

type Levels = readonly { readonly item: string; readonly level: number }[];

function at(place: string, station: boolean, doubts: readonly DoubtView[], levels: Levels): readonly Doubt[] {
  return doubts.map((doubt) => ({ ...doubt, place, station, level: levels.find(({ item }) => item === doubt.item)?.level ?? 0 }));
}
