/** What people have closed: barred and with a sign where nobody may drive, an arrow where one way is left, dotted where it is slow. */
import type { ClosureView } from "../../api/types";
import type { Place, Roads } from "../../motion/roads";
import { format } from "../../text";
import { type Rect, toScreenX, toScreenY } from "../surface/geometry";
import { type Brush, setFont, textPx } from "./brush";
import { placed, type Taken } from "./labels";
import { traceOutline } from "./outline";

const WIDTH_M = 1.5;
const SIGN_M = 0.75;

interface Segment {
  readonly a: Place;
  readonly b: Place;
}

/**
 * Returns where signs and words stand on them.
 *
 * @param taken what else is there: their words stand beside it
 */
export function drawClosures(brush: Brush, roads: Roads, closures: Iterable<ClosureView>, nowS: number, taken: Taken): Rect[] {
  const shown = [...closures];
  for (const { kind, outline } of shown) drawShape(brush, outline, kind === "closed");
  const drawn = shown.map((closure) => ({ closure, segments: segmentsOf(roads, closure) }));
  for (const { closure, segments } of drawn) {
    if (closure.kind === "slow") drawSlow(brush, segments);
    else drawShut(brush, segments, closure.kind === "closed");
  }
  const placedAt = drawn.flatMap(({ closure, segments }) => {
    const at = middleOf(segments);
    return at ? [{ closure, sign: signOf(brush, closure, at) }] : [];
  });
  for (const { closure, sign } of placedAt) if (closure.kind !== "slow") drawSign(brush, roads, closure, sign);
  const signs = placedAt.flatMap(({ closure, sign: { r, x, y } }) => (closure.kind === "slow" ? [] : [{ left: x - r, right: x + r, top: y - r, bottom: y + r }]));
  const labels = placedAt.flatMap(({ closure, sign }) => {
    const text = wordsOn(closure, nowS);
    return text === "" ? [] : [{ text, sign }];
  });
  return [...signs, ...drawLabels(brush, labels, { things: taken.things, words: [...taken.words, ...signs] })];
}

/** The sign in the middle of what is closed; of no size where there is none, since one drives there, only slowly. */
interface Sign {
  readonly x: number;
  readonly y: number;
  readonly r: number;
}

function signOf({ view }: Brush, { kind }: ClosureView, at: Place): Sign {
  return { x: toScreenX(view, at.x), y: toScreenY(view, at.y), r: kind === "slow" ? 0 : Math.max(8, SIGN_M * view.scale) };
}

/** How fast one drives there, and until when. */
function wordsOn(closure: ClosureView, nowS: number): string {
  const until = closure.until_at_s === null ? "" : `– ${format.due(closure.until_at_s, nowS)}`;
  const speed = closure.speed_mps === null ? "" : `${format.number(closure.speed_mps, 1)} m/s`;
  return [speed, until].filter((each) => each !== "").join(" ");
}

/** The part of the floor that somebody has drawn. */
function drawShape(brush: Brush, outline: ClosureView["outline"], closed: boolean): void {
  if (outline.length === 0) return;
  const { ctx, palette } = brush;
  traceOutline(brush, outline.map(({ x_m, y_m }) => [x_m, y_m] as const));
  ctx.globalAlpha = closed ? 0.7 : 0.35;
  ctx.fillStyle = palette["warn-soft"];
  ctx.fill();
  ctx.globalAlpha = 1;
  ctx.strokeStyle = palette.warn;
  ctx.lineWidth = 1.5;
  ctx.setLineDash(closed ? [] : [2, 5]);
  ctx.stroke();
  ctx.setLineDash([]);
}

/** A frame around the lane that is chosen. */
export function drawChosenLane(brush: Brush, roads: Roads, lane: { start: string; end: string }): void {
  const a = roads.places.get(lane.start);
  const b = roads.places.get(lane.end);
  if (!a || !b) return;
  const { ctx, palette } = brush;
  ctx.lineCap = "round";
  stroke(brush, [{ a, b }], palette.chosen, Math.max(4, WIDTH_M * brush.view.scale));
  stroke(brush, [{ a, b }], palette["chosen-soft"], Math.max(1, WIDTH_M * brush.view.scale - 4));
  ctx.lineCap = "butt";
}

/** Each lane once, whichever way it runs. */
function segmentsOf(roads: Roads, { lanes }: ClosureView): Segment[] {
  const seen = new Set<string>();
  return lanes.flatMap(({ end, start }) => {
    const a = roads.places.get(start);
    const b = roads.places.get(end);
    if (!a || !b || seen.has(`${end}>${start}`)) return [];
    seen.add(`${start}>${end}`);
    return [{ a, b }];
  });
}

function stroke({ ctx, view }: Brush, segments: readonly Segment[], colour: string, width: number): void {
  ctx.strokeStyle = colour;
  ctx.lineWidth = width;
  ctx.beginPath();
  for (const { a, b } of segments) {
    ctx.moveTo(toScreenX(view, a.x), toScreenY(view, a.y));
    ctx.lineTo(toScreenX(view, b.x), toScreenY(view, b.y));
  }
  ctx.stroke();
}

/** Edges, and bars across the lane where nobody may drive: it says "closed" without its colour, too. */
function drawShut(brush: Brush, segments: readonly Segment[], barred: boolean): void {
  const { ctx, palette, view } = brush;
  const width = Math.max(4, WIDTH_M * view.scale);
  stroke(brush, segments, palette.warn, width);
  stroke(brush, segments, palette["warn-soft"], width - 3);
  if (!barred) return;
  ctx.setLineDash([3, 5]);
  stroke(brush, segments, palette.warn, width - 3);
  ctx.setLineDash([]);
}

function drawSlow(brush: Brush, segments: readonly Segment[]): void {
  const { ctx, palette, view } = brush;
  stroke(brush, segments, palette["warn-soft"], Math.max(4, WIDTH_M * view.scale));
  ctx.lineCap = "round";
  ctx.setLineDash([0.1, 7]);
  stroke(brush, segments, palette.warn, 3);
  ctx.setLineDash([]);
  ctx.lineCap = "butt";
}

/** The middle of that lane which is nearest to the middle of all. */
function middleOf(segments: readonly Segment[]): Place | null {
  const middles = segments.map(({ a, b }) => ({ x: (a.x + b.x) / 2, y: (a.y + b.y) / 2 }));
  if (middles.length === 0) return null;
  const x = middles.reduce((sum, each) => sum + each.x, 0) / middles.length;
  const y = middles.reduce((sum, each) => sum + each.y, 0) / middles.length;
  return middles.reduce((best, each) => (Math.hypot(each.x - x, each.y - y) < Math.hypot(best.x - x, best.y - y) ? each : best));
}

function drawSign(brush: Brush, roads: Roads, { kind, lane }: ClosureView, { r, x, y }: Sign): void {
  const { ctx, palette } = brush;
  ctx.beginPath();
  ctx.arc(x, y, r, 0, 2 * Math.PI);
  ctx.fillStyle = palette.raised;
  ctx.fill();
  ctx.strokeStyle = palette.warn;
  ctx.lineWidth = 2;
  ctx.stroke();
  ctx.beginPath();
  if (kind === "one_way" && lane) traceArrow(brush, roads, lane, x, y, r);
  else {
    ctx.moveTo(x - r / 2, y);
    ctx.lineTo(x + r / 2, y);
  }
  ctx.lineWidth = kind === "one_way" ? 2 : 3;
  ctx.stroke();
}

/** From where it may be entered to where it leads. */
function traceArrow({ ctx }: Brush, roads: Roads, lane: { start: string; end: string }, x: number, y: number, r: number): void {
  const a = roads.places.get(lane.start);
  const b = roads.places.get(lane.end);
  if (!a || !b) return;
  const angle = Math.atan2(a.y - b.y, b.x - a.x);
  const [dx, dy] = [Math.cos(angle), Math.sin(angle)];
  const tip = { x: x + dx * r * 0.6, y: y + dy * r * 0.6 };
  ctx.moveTo(x - dx * r * 0.6, y - dy * r * 0.6);
  ctx.lineTo(tip.x, tip.y);
  for (const side of [-1, 1]) {
    ctx.moveTo(tip.x, tip.y);
    ctx.lineTo(tip.x - r * 0.5 * Math.cos(angle + side * 0.6), tip.y - r * 0.5 * Math.sin(angle + side * 0.6));
  }
}

/** From a sign to its words. */
const GAP_PX = 4;

/** Below their signs, else above or beside them, and farther off where all of that is taken. */
function drawLabels(brush: Brush, labels: readonly { text: string; sign: Sign }[], taken: Taken): Rect[] {
  const { ctx, palette, view } = brush;
  const px = textPx(view.scale, 0.8, 10, 14);
  setFont(brush, px, 600);
  const wishes = labels.map(({ sign: { r, x, y }, text }) => {
    const [width, height] = [ctx.measureText(text).width + 8, px + 6];
    const places = [0, 1, 2].flatMap((row) => {
      const [dx, dy] = [r + GAP_PX + width / 2, (r === 0 ? 0 : r + GAP_PX) + height / 2 + row * height];
      return [{ x, y: y + dy }, { x, y: y - dy }, ...[dx, -dx].map((away) => ({ x: x + away, y: y + row * height }))];
    });
    return { width, height, must: true, always: true, places };
  });
  ctx.textAlign = "center";
  ctx.textBaseline = "middle";
  ctx.lineWidth = 1;
  return placed(wishes, taken).flatMap((rect, i) => {
    const text = labels[i]?.text;
    if (!rect || text === undefined) return [];
    ctx.beginPath();
    ctx.roundRect(rect.left, rect.top, rect.right - rect.left, rect.bottom - rect.top, 3);
    ctx.fillStyle = palette.raised;
    ctx.fill();
    ctx.strokeStyle = palette.warn;
    ctx.stroke();
    ctx.fillStyle = palette.warn;
    ctx.fillText(text, (rect.left + rect.right) / 2, (rect.top + rect.bottom) / 2);
    return [rect];
  });
}
