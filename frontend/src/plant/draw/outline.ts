/** What somebody draws on the floor: its corners, and the shape that they make. */
import { type Corner, shapeOf } from "../../selection/outline";
import { toScreenX, toScreenY } from "../surface/geometry";
import type { Brush } from "./brush";

const CORNER_PX = 4;
const CROSS_PX = 9;

export function traceOutline({ ctx, view }: Brush, corners: readonly Corner[]): void {
  ctx.beginPath();
  for (const [x, y] of corners) ctx.lineTo(toScreenX(view, x), toScreenY(view, y));
  ctx.closePath();
}

export function drawOutline(brush: Brush, corners: readonly Corner[], drawing: boolean): void {
  const { ctx, palette, size, view } = brush;
  traceOutline(brush, shapeOf(corners));
  ctx.globalAlpha = 0.5;
  ctx.fillStyle = palette["chosen-soft"];
  ctx.fill();
  ctx.globalAlpha = 1;
  ctx.strokeStyle = palette.chosen;
  ctx.lineWidth = 2;
  ctx.stroke();
  ctx.fillStyle = palette.chosen;
  for (const [x, y] of corners) {
    ctx.beginPath();
    ctx.arc(toScreenX(view, x), toScreenY(view, y), CORNER_PX, 0, 2 * Math.PI);
    ctx.fill();
  }
  if (!drawing) return;
  // Where the key Enter sets a corner.
  const [x, y] = [size.width / 2, size.height / 2];
  ctx.beginPath();
  ctx.moveTo(x - CROSS_PX, y);
  ctx.lineTo(x + CROSS_PX, y);
  ctx.moveTo(x, y - CROSS_PX);
  ctx.lineTo(x, y + CROSS_PX);
  ctx.lineWidth = 1;
  ctx.stroke();
}
