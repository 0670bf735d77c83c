/** Held places, waits and jams on the map; loaded where vehicles drive with right of way. */
import type { Place } from "../../motion/roads";
import { type Brush, setFont } from "../draw/brush";
import { placed, type Taken, type Wish, within } from "../draw/labels";
import { type Rect, toScreenX, toScreenY } from "../surface/geometry";
import type { Jam, WaitLine } from "./held";

/** As wide as a vehicle. */
const HELD_M = 0.9;
const LABEL_PX = 11.5;
const HEAD_PX = 7;

/** Barred in grey: what is held is the vehicle's own, but nothing is wrong with it. */
export function drawHeld(brush: Brush, lines: readonly (readonly Place[])[]): void {
  const { ctx, detail, palette, view } = brush;
  const width = Math.max(2, HELD_M * view.scale);
  ctx.lineCap = "butt";
  ctx.lineJoin = "round";
  ctx.beginPath();
  for (const points of lines) trace(brush, points);
  if (!detail.vehicleParts) {
    ctx.globalAlpha = 0.6;
    stroke(ctx, palette.steel, width);
    ctx.globalAlpha = 1;
    return;
  }
  stroke(ctx, palette.steel, width);
  stroke(ctx, palette.lane, width - 2);
  ctx.setLineDash([1.5, 3.5]);
  stroke(ctx, palette.steel, width - 2);
  ctx.setLineDash([]);
}

/** An arc beside the lane from each vehicle to the one that it waits for. */
export function drawWaits(brush: Brush, lines: readonly WaitLine[]): void {
  const { ctx, palette } = brush;
  for (const chosen of [false, true]) {
    const colour = chosen ? palette.chosen : palette["ink-2"];
    const arcs = lines.filter((line) => line.chosen === chosen).map((line) => arcOf(brush, line));
    ctx.beginPath();
    for (const { bend, from, to } of arcs) {
      ctx.moveTo(from.x, from.y);
      ctx.quadraticCurveTo(bend.x, bend.y, to.x, to.y);
    }
    ctx.setLineDash([4, 3]);
    stroke(ctx, colour, chosen ? 2.25 : 1.5);
    ctx.setLineDash([]);
    if (!brush.detail.vehicleParts && !chosen) continue;
    ctx.beginPath();
    for (const { bend, to } of arcs) traceHead(ctx, Math.atan2(to.y - bend.y, to.x - bend.x), to);
    ctx.fillStyle = colour;
    ctx.fill();
  }
}

/** One outline around all that are in a jam: the first thing on its canvas, and what lies under it stays legible. */
export function drawJams(brush: Brush, jams: readonly Jam[]): void {
  if (jams.length === 0) return;
  const { ctx, detail, palette } = brush;
  ctx.lineCap = "round";
  ctx.lineJoin = "round";
  const width = 2 * detail.vehiclePx + 14;
  ctx.beginPath();
  // A line of no length has no round ends in every browser.
  for (const { lines } of jams) for (const { from, to } of lines) trace(brush, [from, { x: to.x + 1e-4, y: to.y }]);
  stroke(ctx, palette.alarm, width);
  ctx.globalCompositeOperation = "destination-out";
  stroke(ctx, palette.alarm, width - 4);
  ctx.globalCompositeOperation = "source-over";
  ctx.globalAlpha = 0.16;
  stroke(ctx, palette.alarm, width - 4);
  ctx.globalAlpha = 1;
  ctx.lineCap = "butt";
}

/** Which jam it is, and for how long, on a ground of its own. */
export interface JamSign {
  readonly text: string;
  readonly rect: Rect;
}

/** From the outermost vehicle of a jam to the middle of its sign: between them a name has room. */
const AWAY_PX = 34;
/** How many rows of places there are on each side. */
const ROWS = 5;

/** Beside the jams that are in sight, within the map, and where no other words stand as long as there is such a place. */
export function jamSigns(brush: Brush, jams: readonly (Jam & { text: string })[], taken: Taken): JamSign[] {
  setFont(brush, LABEL_PX, 650);
  const shown = jams.filter(({ lines }) => lines.some(({ from, to }) => isOnScreen(brush, from) || isOnScreen(brush, to)));
  const wishes = shown.map(({ lines, text }): Wish => {
    const size = { width: brush.ctx.measureText(text).width + 14, height: 20 };
    return { ...size, must: true, always: true, places: placesBeside(brush, lines, size) };
  });
  return placed(wishes, taken).flatMap((rect, i) => {
    const text = shown[i]?.text;
    return rect && text !== undefined ? [{ text, rect }] : [];
  });
}

/** Above and below all of a jam, the nearest first, then at its sides. */
function placesBeside({ detail, size: room, view }: Brush, lines: Jam["lines"], size: { width: number; height: number }): Wish["places"] {
  const ends = lines.flatMap(({ from, to }) => [from, to]);
  const [xs, ys] = [ends.map(({ x }) => toScreenX(view, x)), ends.map(({ y }) => toScreenY(view, y))];
  const [left, right, top, bottom] = [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
  const x = xs.reduce((sum, each) => sum + each, 0) / xs.length;
  const y = ys.reduce((sum, each) => sum + each, 0) / ys.length;
  const rows = Array.from({ length: ROWS }, (_, row) => detail.vehiclePx + AWAY_PX + row * size.height);
  const aside = size.width / 2 + detail.vehiclePx + AWAY_PX / 2;
  const over = rows.flatMap((away) => [top - away, bottom + away].flatMap((at) => [x, left, right].map((each) => ({ x: each, y: at }))));
  const beside = [left - aside, right + aside].map((each) => ({ x: each, y }));
  return [...over.slice(0, 6), ...beside, ...over.slice(6)].map((place) => within(place, size, room));
}

/** Over everything. */
export function nameJams(brush: Brush, signs: readonly JamSign[]): void {
  const { ctx, palette } = brush;
  setFont(brush, LABEL_PX, 650);
  ctx.textAlign = "center";
  ctx.textBaseline = "middle";
  for (const { rect: { bottom, left, right, top }, text } of signs) {
    ctx.beginPath();
    ctx.roundRect(left, top, right - left, bottom - top, 4);
    ctx.fillStyle = palette.alarm;
    ctx.fill();
    ctx.fillStyle = palette.raised;
    ctx.fillText(text, (left + right) / 2, (top + bottom) / 2 + 0.5);
  }
}

/** From rim to rim, bent to the right of the way there, so that two that wait for one another have two arcs. */
function arcOf({ detail, view }: Brush, line: WaitLine) {
  const a = { x: toScreenX(view, line.from.x), y: toScreenY(view, line.from.y) };
  const b = { x: toScreenX(view, line.to.x), y: toScreenY(view, line.to.y) };
  const length = Math.hypot(b.x - a.x, b.y - a.y) || 1;
  const away = Math.max(0.22 * length, detail.vehicleParts ? 1.5 * detail.vehiclePx : 0);
  const bend = {
    x: (a.x + b.x) / 2 - ((b.y - a.y) / length) * away,
    y: (a.y + b.y) / 2 + ((b.x - a.x) / length) * away,
  };
  const rim = detail.vehiclePx + 1;
  return { from: towards(a, bend, rim), bend, to: towards(b, bend, rim + 2) };
}

function towards(from: Place, to: Place, px: number): Place {
  const length = Math.hypot(to.x - from.x, to.y - from.y) || 1;
  return { x: from.x + ((to.x - from.x) / length) * px, y: from.y + ((to.y - from.y) / length) * px };
}

function traceHead(ctx: CanvasRenderingContext2D, angle: number, tip: Place): void {
  ctx.moveTo(tip.x, tip.y);
  for (const side of [-0.45, 0.45]) ctx.lineTo(tip.x - HEAD_PX * Math.cos(angle + side), tip.y - HEAD_PX * Math.sin(angle + side));
  ctx.closePath();
}

function isOnScreen({ size, view }: Brush, { x, y }: Place): boolean {
  const [left, top] = [toScreenX(view, x), toScreenY(view, y)];
  return left >= 0 && top >= 0 && left <= size.width && top <= size.height;
}

function trace({ ctx, view }: Brush, points: readonly Place[]): void {
  points.forEach(({ x, y }, i) => {
    if (i === 0) ctx.moveTo(toScreenX(view, x), toScreenY(view, y));
    else ctx.lineTo(toScreenX(view, x), toScreenY(view, y));
  });
}

function stroke(ctx: CanvasRenderingContext2D, colour: string, width: number): void {
  ctx.strokeStyle = colour;
  ctx.lineWidth = width;
  ctx.stroke();
}
