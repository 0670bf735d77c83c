/** Lines between things: planned ways, who works for whom, who watches whom, who relays for whom. */
import type { Place } from "../../motion/roads";
import { toScreenX, toScreenY } from "../surface/geometry";
import type { Brush } from "./brush";
import { placesAlong } from "./labels";
import type { Words } from "./words";

/** @param ways the points still ahead of each vehicle, from where it is shown */
export function drawWays(brush: Brush, ways: readonly (readonly Place[])[]): void {
  const { ctx, palette } = brush;
  ctx.beginPath();
  for (const points of ways) tracePoints(brush, points);
  ctx.globalAlpha = 0.5;
  stroke(ctx, palette.link, 1.75);
  ctx.globalAlpha = 1;
}

export function drawChosenWay(brush: Brush, points: readonly Place[]): void {
  const { ctx, view, palette } = brush;
  const end = points.at(-1);
  if (points.length < 2 || !end) return;
  ctx.beginPath();
  tracePoints(brush, points);
  stroke(ctx, palette.chosen, Math.max(3, 0.28 * view.scale));
  ctx.beginPath();
  ctx.arc(toScreenX(view, end.x), toScreenY(view, end.y), Math.max(4, 0.35 * view.scale), 0, 2 * Math.PI);
  ctx.fillStyle = palette.floor;
  ctx.fill();
  stroke(ctx, palette.chosen, 2.5);
}

export interface Line {
  readonly from: Place;
  readonly to: Place;
}

/** `overdue`: the one that is watched should have been heard by now. */
export type LineStyle = "primary" | "secondary" | "overdue" | "mesh";

/** A shorter line leaves no room for an age. */
const AGED_PX = 56;
const AGE_PX = 11;

/**
 * @param strong for the chosen ones; everybody else's are faint
 */
export function drawLinks(brush: Brush, lines: readonly Line[], style: LineStyle, strong: boolean): void {
  if (lines.length === 0) return;
  const { ctx, palette } = brush;
  ctx.beginPath();
  for (const line of lines) tracePoints(brush, [line.from, line.to]);
  ctx.globalAlpha = strong ? 1 : 0.55;
  if (style === "mesh") {
    ctx.lineCap = "round";
    ctx.setLineDash([4, 6]);
    stroke(ctx, palette.warn, 2.5);
  } else {
    ctx.setLineDash(style === "primary" ? [] : [6, 4]);
    if (style === "overdue") stroke(ctx, palette.warn, 2);
    else stroke(ctx, strong ? palette.chosen : palette.link, strong ? 1.75 : 1);
  }
  ctx.setLineDash([]);
  ctx.lineCap = "butt";
  ctx.globalAlpha = 1;
}

/** On the lines of a watch, how long ago the one at their end was heard. */
export function agesOn({ view }: Brush, lines: readonly (Line & { age: string; overdue: boolean })[]): Words[] {
  const at = ({ x, y }: Place) => ({ x: toScreenX(view, x), y: toScreenY(view, y) });
  return lines
    .filter(({ from, to }) => Math.hypot(to.x - from.x, to.y - from.y) * view.scale >= AGED_PX)
    .map(({ age, from, overdue, to }) => ({
      text: age, px: AGE_PX, edgePx: 4, must: true, colour: overdue ? "warn" : "chosen", places: () => placesAlong(at(from), at(to)),
    }));
}

function tracePoints({ ctx, view }: Brush, points: readonly Place[]): void {
  points.forEach((point, i) => {
    const x = toScreenX(view, point.x);
    const y = toScreenY(view, point.y);
    if (i === 0) ctx.moveTo(x, y);
    else ctx.lineTo(x, y);
  });
}

function stroke(ctx: CanvasRenderingContext2D, colour: string, width: number): void {
  ctx.strokeStyle = colour;
  ctx.lineWidth = width;
  ctx.lineJoin = "round";
  ctx.stroke();
}
