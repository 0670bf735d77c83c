/** What is meant by a click: the nearest vehicle within reach, else the place underneath. */
import type { Box } from "../../api/types";
import type { Chosen } from "../../selection/selection";
import { boxOnScreen, contains, toScreenX, toScreenY, type View } from "./geometry";

export interface Pickable {
  readonly id: string;
  readonly kind: "machine" | "place";
  readonly box: Box;
}

/** Half of the 44 px that a finger needs, less a little so that neighbours stay apart. */
const REACH_PX = 18;

export function pick(
  view: View,
  x: number,
  y: number,
  vehicles: Iterable<{ view: { id: string }; x: number; y: number }>,
  places: Iterable<Pickable>,
): Chosen | null {
  let best: Chosen | null = null;
  let bestPx = REACH_PX;
  for (const vehicle of vehicles) {
    const dx = toScreenX(view, vehicle.x) - x;
    const dy = toScreenY(view, vehicle.y) - y;
    const px = Math.hypot(dx, dy);
    if (px < bestPx) {
      bestPx = px;
      best = { kind: "atv", id: vehicle.view.id };
    }
  }
  if (best) return best;
  for (const place of places) {
    if (contains(boxOnScreen(view, place.box), x, y, 3)) return { kind: place.kind, id: place.id };
  }
  return null;
}
