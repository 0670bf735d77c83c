/** The road network as the panels need it: where nodes are, and the way a vehicle must have taken. */
import type { PlantFile } from "../api/types";

export interface Place {
  readonly x: number;
  readonly y: number;
}

export interface Roads {
  readonly places: ReadonlyMap<string, Place>;
  readonly next: ReadonlyMap<string, readonly string[]>;
}

export function roadsOf(plant: Pick<PlantFile, "nodes" | "lanes">): Roads {
  const places = new Map(plant.nodes.map((node) => [node.id, { x: node.x_m, y: node.y_m }]));
  const next = new Map<string, string[]>(plant.nodes.map((node) => [node.id, []]));
  for (const lane of plant.lanes) {
    next.get(lane.start)?.push(lane.end);
    if (lane.both_ways) next.get(lane.end)?.push(lane.start);
  }
  return { places, next };
}

/** A vehicle passes few nodes between two heartbeats; a longer search means that news was missed. */
const LONGEST_HOPS = 10;

/**
 * The nodes between `from` and `to` with the fewest lanes, both ends included; null where none is
 * near. Used only where a vehicle's own plan does not say how it got there.
 */
export function hopsBetween(roads: Roads, from: string, to: string): string[] | null {
  const cameFrom = new Map<string, string | null>([[from, null]]);
  let edge = [from];
  for (let hops = 0; hops <= LONGEST_HOPS && edge.length > 0; hops += 1) {
    if (cameFrom.has(to)) return backFrom(cameFrom, to);
    const beyond: string[] = [];
    for (const node of edge) {
      for (const after of roads.next.get(node) ?? []) {
        if (cameFrom.has(after)) continue;
        cameFrom.set(after, node);
        beyond.push(after);
      }
    }
    edge = beyond;
  }
  return null;
}

function backFrom(cameFrom: ReadonlyMap<string, string | null>, to: string): string[] {
  const nodes: string[] = [];
  for (let node: string | null = to; node !== null; node = cameFrom.get(node) ?? null) {
    nodes.unshift(node);
  }
  return nodes;
}
