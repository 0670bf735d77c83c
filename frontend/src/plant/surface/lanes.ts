/** Which lane is meant by a click beside everything that has a shape of its own. */
import type { Lane, PlantFile } from "../../api/types";
import type { Place } from "../../motion/roads";
import { toScreenX, toScreenY, type View } from "./geometry";

/** Half of a drawn lane at an ordinary zoom. */
const REACH_PX = 12;

const SEPARATOR = ">";

/** A lane's name in a selection. Ids of nodes have no such character in plant files that people write by hand. */
export function laneId(lane: Pick<Lane, "start" | "end">): string {
  return `${lane.start}${SEPARATOR}${lane.end}`;
}

export function laneOf(id: string): { start: string; end: string } | null {
  const [start, end, ...more] = id.split(SEPARATOR);
  return start && end && more.length === 0 ? { start, end } : null;
}

/** The road, by the ends that it was drawn with, of which a lane is one of two; the lane itself where it is none. */
export function roadOf({ end, start }: Pick<Lane, "start" | "end">): { start: string; end: string } {
  const [, from, to] = /^(.+)\.to-(.+)$/.exec(start) ?? [];
  return from !== undefined && to !== undefined && end === `${to}.from-${from}` ? { start: from, end: to } : { start, end };
}

/** The lane nearest to a point of the screen, within reach; null where none is. */
export function pickLane(view: View, plant: PlantFile, x: number, y: number): string | null {
  const places = placesOf(plant);
  let best: string | null = null;
  let bestPx = REACH_PX;
  for (const lane of plant.lanes) {
    const a = places.get(lane.start);
    const b = places.get(lane.end);
    if (!a || !b) continue;
    const px = distance(x, y, toScreenX(view, a.x), toScreenY(view, a.y), toScreenX(view, b.x), toScreenY(view, b.y));
    if (px < bestPx) {
      bestPx = px;
      best = laneId(lane);
    }
  }
  return best;
}

let known: { plant: PlantFile; places: ReadonlyMap<string, Place> } | null = null;

function placesOf(plant: PlantFile): ReadonlyMap<string, Place> {
  if (known?.plant !== plant) {
    known = { plant, places: new Map(plant.nodes.map((node) => [node.id, { x: node.x_m, y: node.y_m }])) };
  }
  return known.places;
}

/** From a point to a straight piece of line. */
function distance(x: number, y: number, ax: number, ay: number, bx: number, by: number): number {
  const along = (bx - ax) ** 2 + (by - ay) ** 2;
  const part = along === 0 ? 0 : Math.min(1, Math.max(0, ((x - ax) * (bx - ax) + (y - ay) * (by - ay)) / along));
  return Math.hypot(x - ax - part * (bx - ax), y - ay - part * (by - ay));
}
