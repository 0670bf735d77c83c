/** Takeovers: a line from the one that failed to the one that carries on, and waves around the latter. */
import type { Place } from "../../motion/roads";
import { toScreenX, toScreenY } from "../surface/geometry";
import type { MarkLook } from "../surface/marks";
import type { Brush } from "./brush";

const HEAD_PX = 9;

export function drawMark(brush: Brush, from: Place | undefined, to: Place | undefined, look: MarkLook): void {
  if (!to) return;
  const { ctx, view, palette, detail } = brush;
  const x = toScreenX(view, to.x);
  const y = toScreenY(view, to.y);
  const r = detail.vehiclePx + 4;
  ctx.strokeStyle = palette.chosen;
  if (from) {
    ctx.globalAlpha = look.lineAlpha;
    drawArrow(brush, toScreenX(view, from.x), toScreenY(view, from.y), x, y, r);
  }
  if (look.wave) {
    ctx.globalAlpha = look.wave.alpha;
    ctx.beginPath();
    ctx.arc(x, y, r + look.wave.px, 0, 2 * Math.PI);
    ctx.lineWidth = 3;
    ctx.stroke();
  }
  ctx.globalAlpha = 1;
}

/** Ends at the rim, so that the vehicle stays visible. */
function drawArrow({ ctx, palette }: Brush, x1: number, y1: number, x2: number, y2: number, rimPx: number): void {
  const length = Math.hypot(x2 - x1, y2 - y1);
  if (length < 2 * rimPx) return;
  const angle = Math.atan2(y2 - y1, x2 - x1);
  const at = (px: number, turn: number, from: { x: number; y: number }) => ({
    x: from.x + px * Math.cos(angle + turn),
    y: from.y + px * Math.sin(angle + turn),
  });
  const begin = at(rimPx, 0, { x: x1, y: y1 });
  const end = at(-rimPx, 0, { x: x2, y: y2 });
  ctx.beginPath();
  ctx.moveTo(begin.x, begin.y);
  ctx.lineTo(end.x, end.y);
  ctx.lineWidth = 2.5;
  ctx.setLineDash([9, 5]);
  ctx.stroke();
  ctx.setLineDash([]);
  const left = at(-HEAD_PX, 0.5, end);
  const right = at(-HEAD_PX, -0.5, end);
  ctx.beginPath();
  ctx.moveTo(end.x, end.y);
  ctx.lineTo(left.x, left.y);
  ctx.lineTo(right.x, right.y);
  ctx.closePath();
  ctx.fillStyle = palette.chosen;
  ctx.fill();
}
