/** What vehicles have met on lanes: a warning sign in the middle of the lane. A door has a sign of its own. */
import type { ObstacleView, PlantFile } from "../../api/types";
import type { Roads } from "../../motion/roads";
import { type Rect, toScreenX, toScreenY } from "../surface/geometry";
import { doorOn } from "../doors/on";
import { type Brush, setFont } from "./brush";

const SIGN_M = 0.9;

/** Where the signs stand. */
export function obstacleSigns({ view }: Brush, roads: Roads, obstacles: Iterable<ObstacleView>, doors: PlantFile["doors"]): Rect[] {
  const r = Math.max(9, SIGN_M * view.scale);
  return [...obstacles].flatMap(({ start, end }) => {
    const [a, b] = [roads.places.get(start), roads.places.get(end)];
    if (!a || !b || doorOn(doors, { start, end })) return [];
    const [x, y] = [toScreenX(view, (a.x + b.x) / 2), toScreenY(view, (a.y + b.y) / 2)];
    return [{ left: x - r, right: x + r, top: y - r, bottom: y + 0.75 * r }];
  });
}

export function drawObstacles(brush: Brush, signs: readonly Rect[]): void {
  const { ctx, palette } = brush;
  for (const { bottom, left, right, top } of signs) {
    const [x, r] = [(left + right) / 2, (right - left) / 2];
    ctx.beginPath();
    ctx.moveTo(x, top);
    ctx.lineTo(right, bottom);
    ctx.lineTo(left, bottom);
    ctx.closePath();
    ctx.fillStyle = palette.raised;
    ctx.fill();
    ctx.lineJoin = "round";
    ctx.strokeStyle = palette.warn;
    ctx.lineWidth = 2;
    ctx.stroke();
    setFont(brush, 1.1 * r, 700);
    ctx.textAlign = "center";
    ctx.textBaseline = "middle";
    ctx.fillStyle = palette.warn;
    ctx.fillText("!", x, top + 1.2 * r);
  }
}
