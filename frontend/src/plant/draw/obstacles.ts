/** What vehicles have met on lanes: a warning sign in the middle of the lane. A door has a sign of its own. */
import type { ObstacleView, PlantFile } from "../../api/types";
import type { Roads } from "../../motion/roads";
import { toScreenX, toScreenY } from "../surface/geometry";
import { doorOn } from "../doors/on";
import { type Brush, setFont } from "./brush";

const SIGN_M = 0.9;

export function drawObstacles(brush: Brush, roads: Roads, obstacles: Iterable<ObstacleView>, doors: PlantFile["doors"]): void {
  const { ctx, palette, view } = brush;
  for (const { start, end } of obstacles) {
    if (doorOn(doors, { start, end })) continue;
    const a = roads.places.get(start);
    const b = roads.places.get(end);
    if (!a || !b) continue;
    const x = toScreenX(view, (a.x + b.x) / 2);
    const y = toScreenY(view, (a.y + b.y) / 2);
    const r = Math.max(9, SIGN_M * view.scale);
    ctx.beginPath();
    ctx.moveTo(x, y - r);
    ctx.lineTo(x + r, y + 0.75 * r);
    ctx.lineTo(x - r, y + 0.75 * r);
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
    ctx.fillText("!", x, y + 0.2 * r);
  }
}
