/** What never moves: floor, areas, lanes and the places that only stand there. */
import type { Box, ClosureView, Lane, PlantFile } from "../../api/types";
import type { Place, Roads } from "../../motion/roads";
import type { Outline } from "../../selection/outline";
import { type Heat, stepOf } from "../heat/heat";
import { boxOnScreen, isInside, overlaps, type Rect, toFloorX, toFloorY, toScreenX, toScreenY } from "../surface/geometry";
import { type Brush, isInSight, setFont, textPx } from "./brush";
import { drawChosenLane, drawClosures } from "./closures";
import { drawObstacles } from "./obstacles";
import { drawOutline } from "./outline";
import { rectOfWords } from "./words";

export interface FloorPlan {
  readonly plant: PlantFile;
  readonly roads: Roads;
  /** The names of the areas, as `areaNames` places them; null where areas are not shown. */
  readonly areas: readonly AreaName[] | null;
  readonly showLabels: boolean;
  readonly heat: Heat | null;
  /** Id of the chosen place. */
  readonly chosen: string | null;
  readonly closures: Iterable<ClosureView>;
  /** Where signs of obstacles stand. */
  readonly obstacles: readonly Rect[];
  /** Where the letters at parking places stand. */
  readonly parkings: readonly Rect[];
  /** The chosen lane, by its ends. */
  readonly lane: { start: string; end: string } | null;
  /** What somebody draws, if anything. */
  readonly outline: Outline | null;
  readonly nowS: number;
}

/** A lane's drawn width: a vehicle and some air. */
const LANE_M = 1.5;
/** Slower lanes are spurs to docks, and drawn as such. */
const SPUR_MPS = 1;
const SPUR_M = 1;
const HEAT_M = 0.6;
const PARKING_M = 2.1;

/** Returns where words and signs stand on it, but for the names of areas, whose places are known. */
export function drawFloor(brush: Brush, plan: FloorPlan): Rect[] {
  drawGround(brush, plan.plant);
  if (plan.areas) drawAreas(brush, plan.plant);
  drawLanes(brush, plan);
  if (plan.heat) drawHeat(brush, plan, plan.heat);
  if (plan.lane) drawChosenLane(brush, plan.roads, plan.lane);
  drawParkings(brush, plan);
  drawChargers(brush, plan.plant);
  const words = [
    ...plan.plant.warehouses.flatMap(({ box, name }) => drawBox(brush, box, "wall", plan.showLabels ? name : "", 1.05)),
    ...plan.plant.storages.flatMap(({ box, id }) => drawBox(brush, box, "panel", plan.showLabels ? id : "", 0.95)),
  ];
  if (plan.areas) nameAreas(brush, plan.areas);
  const { warehouses, storages, chargers } = plan.plant;
  const chosen = [...warehouses, ...storages, ...chargers].find(({ id }) => id === plan.chosen);
  if (chosen) drawFrame(brush, chosen.box);
  const things = [...plan.plant.machines, ...plan.plant.storages, ...plan.plant.warehouses, ...plan.plant.chargers]
    .filter(({ box }) => isInSight(brush, box))
    .map(({ box }) => boxOnScreen(brush.view, box));
  const standing = [...words, ...(plan.areas ?? []).map(({ rect }) => rect), ...plan.obstacles, ...plan.parkings];
  words.push(...drawClosures(brush, plan.roads, plan.closures, plan.nowS, { things, words: standing }));
  drawObstacles(brush, plan.obstacles);
  if (plan.outline) drawOutline(brush, plan.outline.corners, plan.outline.drawing);
  return [...words, ...plan.obstacles];
}

function drawGround(brush: Brush, plant: PlantFile): void {
  const { ctx, view, palette } = brush;
  const box = {
    x_m: plant.width_m / 2,
    y_m: plant.height_m / 2,
    width_m: plant.width_m,
    depth_m: plant.height_m,
  };
  const { left, top, right, bottom } = boxOnScreen(view, box);
  ctx.beginPath();
  ctx.roundRect(left, top, right - left, bottom - top, Math.min(14, view.scale));
  ctx.fillStyle = palette.floor;
  ctx.fill();
  ctx.strokeStyle = palette.line;
  ctx.lineWidth = 1;
  ctx.stroke();
}

function drawAreas(brush: Brush, plant: PlantFile): void {
  const { ctx, view, palette } = brush;
  plant.areas.forEach((area, i) => {
    ctx.beginPath();
    for (const point of area.polygon) {
      ctx.lineTo(toScreenX(view, point.x_m), toScreenY(view, point.y_m));
    }
    ctx.closePath();
    if (i % 2 === 0) {
      ctx.globalAlpha = 0.55;
      ctx.fillStyle = palette["chosen-soft"];
      ctx.fill();
      ctx.globalAlpha = 1;
    }
    ctx.setLineDash([2, 4]);
    ctx.strokeStyle = palette.steel;
    ctx.stroke();
    ctx.setLineDash([]);
  });
}

/** The name of an area, and where it stands on the screen. */
export interface AreaName {
  readonly name: string;
  readonly rect: Rect;
}

/** From the edge of an area to its name. */
const ASIDE_PX = 8;

/**
 * In the lower left corner of each area, else in another one: where no machine, no storage and no other area's name
 * stands, and within the area, also where that is no rectangle.
 *
 * @param signs what else it may not cover
 */
export function areaNames(brush: Brush, plant: PlantFile, signs: readonly Rect[] = []): AreaName[] {
  const { ctx, view } = brush;
  const px = areaPx(view.scale);
  setFont(brush, px, 550);
  const taken = [...signs, ...[...plant.machines, ...plant.storages, ...plant.warehouses].map(({ box }) => boxOnScreen(view, box))];
  return plant.areas.flatMap(({ name, polygon }) => {
    const [xs, ys] = [polygon.map((point) => toScreenX(view, point.x_m)), polygon.map((point) => toScreenY(view, point.y_m))];
    const width = ctx.measureText(name).width;
    const [least, most] = [Math.min(...xs), Math.max(...xs)];
    // A name that is wider than its area would begin in the one to the left.
    const lefts = [least + ASIDE_PX, ...(width + 2 * ASIDE_PX <= most - least ? [most - ASIDE_PX - width] : [])];
    const lowest = Math.max(...ys) - 4 - px;
    const at = (left: number, top: number): Rect => ({ left, right: left + width, top, bottom: top + px });
    const rects = [lowest, Math.min(...ys) + 4].flatMap((top) => lefts.map((left) => at(left, top)));
    const within = rects.filter(({ bottom, left, right, top }) =>
      isInside(polygon, toFloorX(view, (left + right) / 2), toFloorY(view, (top + bottom) / 2)));
    const free = within.find((rect) => !taken.some((other) => overlaps(rect, other)));
    // In an area of no such corner, beside it: on a map that has no room for it, it has no name.
    const rect = free ?? (within.length === 0 ? at(least + ASIDE_PX, lowest) : undefined);
    if (!rect || taken.some((other) => overlaps(rect, other))) return [];
    taken.push(rect);
    return [{ name, rect }];
  });
}

function areaPx(scale: number): number {
  return textPx(scale, 0.9, 11, 16);
}

/** Above what stands there. */
function nameAreas(brush: Brush, names: readonly AreaName[]): void {
  const { ctx, palette, view } = brush;
  setFont(brush, areaPx(view.scale), 550);
  ctx.textAlign = "left";
  ctx.textBaseline = "bottom";
  ctx.lineWidth = 4;
  ctx.lineJoin = "round";
  ctx.strokeStyle = palette.floor;
  ctx.fillStyle = palette["ink-2"];
  for (const { name, rect } of names) {
    ctx.strokeText(name, rect.left, rect.bottom);
    ctx.fillText(name, rect.left, rect.bottom);
  }
}

function drawLanes(brush: Brush, plan: FloorPlan): void {
  const { ctx, view, palette } = brush;
  ctx.strokeStyle = palette.lane;
  ctx.lineCap = "round";
  for (const spurs of [true, false]) {
    ctx.beginPath();
    for (const lane of plan.plant.lanes) {
      if (lane.speed_limit_mps < SPUR_MPS === spurs) traceLane(brush, plan.roads, lane);
    }
    ctx.lineWidth = Math.max(1.5, (spurs ? SPUR_M : LANE_M) * view.scale);
    ctx.stroke();
  }
  ctx.lineCap = "butt";
  if (brush.detail.laneMarks) drawLaneMarks(brush, plan);
}

/** Calm shades of one colour along the middle of the lanes: the busier, the stronger. */
function drawHeat(brush: Brush, plan: FloorPlan, heat: Heat): void {
  const { ctx, view, palette } = brush;
  ctx.strokeStyle = palette.heat;
  ctx.lineWidth = Math.max(2, HEAT_M * view.scale);
  for (let step = 1; step <= heat.steps.length; step += 1) {
    ctx.beginPath();
    for (const lane of plan.plant.lanes) {
      if (stepOf(heat.of(lane), heat.steps) === step) traceLane(brush, plan.roads, lane);
    }
    ctx.globalAlpha = step / heat.steps.length;
    ctx.stroke();
  }
  ctx.globalAlpha = 1;
}

function traceLane({ ctx, view }: Brush, roads: Roads, lane: Lane): void {
  const a = roads.places.get(lane.start);
  const b = roads.places.get(lane.end);
  if (!a || !b) return;
  ctx.moveTo(toScreenX(view, a.x), toScreenY(view, a.y));
  ctx.lineTo(toScreenX(view, b.x), toScreenY(view, b.y));
}

/** A dashed middle where both ways are open, an arrow where only one is. */
function drawLaneMarks(brush: Brush, plan: FloorPlan): void {
  const { ctx, view, palette } = brush;
  ctx.strokeStyle = palette["lane-mark"];
  ctx.lineWidth = Math.max(1, 0.06 * view.scale);
  ctx.setLineDash([0.5 * view.scale, 0.5 * view.scale]);
  ctx.beginPath();
  for (const lane of plan.plant.lanes) {
    if (lane.both_ways && lane.speed_limit_mps >= SPUR_MPS) traceLane(brush, plan.roads, lane);
  }
  ctx.stroke();
  ctx.setLineDash([]);
  ctx.beginPath();
  for (const lane of plan.plant.lanes) {
    const a = plan.roads.places.get(lane.start);
    const b = plan.roads.places.get(lane.end);
    if (!lane.both_ways && a && b) traceArrow(brush, a, b);
  }
  ctx.stroke();
}

function traceArrow({ ctx, view }: Brush, a: Place, b: Place): void {
  const x = toScreenX(view, (a.x + b.x) / 2);
  const y = toScreenY(view, (a.y + b.y) / 2);
  const angle = Math.atan2(a.y - b.y, b.x - a.x);
  const arm = 0.3 * view.scale;
  for (const side of [-1, 1]) {
    ctx.moveTo(x, y);
    ctx.lineTo(x - arm * Math.cos(angle + side * 0.7), y - arm * Math.sin(angle + side * 0.7));
  }
}

function drawParkings(brush: Brush, plan: FloorPlan): void {
  const { ctx, view, palette, detail } = brush;
  const half = (PARKING_M / 2) * view.scale;
  ctx.lineWidth = 1.25;
  ctx.strokeStyle = palette["lane-mark"];
  for (const parking of plan.plant.parkings) {
    const at = plan.roads.places.get(parking.node);
    if (!at || !isInSight(brush, { x_m: at.x, y_m: at.y, width_m: PARKING_M, depth_m: PARKING_M })) continue;
    const x = toScreenX(view, at.x);
    const y = toScreenY(view, at.y);
    ctx.beginPath();
    ctx.roundRect(x - half, y - half, 2 * half, 2 * half, Math.min(5, half / 3));
    ctx.fillStyle = palette.lane;
    ctx.fill();
    if (!detail.machineParts) continue;
    ctx.stroke();
    write(brush, "P", x, y, parkingSignPx(view.scale), "ink-2");
  }
}

/** How high the letter of a parking place is. */
export function parkingSignPx(scale: number): number {
  return textPx(scale, 0.85, 9, 22);
}

function drawChargers(brush: Brush, plant: PlantFile): void {
  const { ctx, view, palette } = brush;
  for (const charger of plant.chargers) {
    if (!isInSight(brush, charger.box)) continue;
    const x = toScreenX(view, charger.box.x_m);
    const y = toScreenY(view, charger.box.y_m);
    const r = (charger.box.width_m * view.scale) / 2;
    ctx.beginPath();
    ctx.arc(x, y, r, 0, 2 * Math.PI);
    ctx.fillStyle = palette.floor;
    ctx.fill();
    ctx.lineWidth = Math.max(1.25, 0.1 * view.scale);
    ctx.strokeStyle = palette.steel;
    ctx.stroke();
    ctx.fillStyle = palette.steel;
    ctx.beginPath();
    traceBolt(ctx, x, y, r * 0.62);
    ctx.fill();
  }
}

/** A lightning bolt of the given half height. */
export function traceBolt(ctx: CanvasRenderingContext2D, x: number, y: number, half: number): void {
  ctx.moveTo(x + 0.2 * half, y - half);
  ctx.lineTo(x - 0.6 * half, y + 0.15 * half);
  ctx.lineTo(x - 0.02 * half, y + 0.15 * half);
  ctx.lineTo(x - 0.2 * half, y + half);
  ctx.lineTo(x + 0.6 * half, y - 0.2 * half);
  ctx.lineTo(x + 0.05 * half, y - 0.2 * half);
  ctx.closePath();
}

function drawFrame({ ctx, view, palette }: Brush, box: Box): void {
  const { left, top, right, bottom } = boxOnScreen(view, box);
  ctx.beginPath();
  ctx.roundRect(left - 4, top - 4, right - left + 8, bottom - top + 8, 8);
  ctx.lineWidth = 2.5;
  ctx.strokeStyle = palette.chosen;
  ctx.stroke();
}

type BoxFill = "wall" | "panel";

function drawBox(
  brush: Brush,
  box: Box,
  fill: BoxFill,
  name: string,
  textM: number,
): Rect[] {
  if (!isInSight(brush, box)) return [];
  const { ctx, view, palette, detail } = brush;
  const { left, top, right, bottom } = boxOnScreen(view, box);
  ctx.beginPath();
  ctx.roundRect(left, top, right - left, bottom - top, Math.min(6, 0.35 * view.scale));
  ctx.fillStyle = palette[fill];
  ctx.fill();
  if (fill === "panel") {
    ctx.lineWidth = Math.min(3, Math.max(1, 0.11 * view.scale));
    ctx.strokeStyle = palette.steel;
    ctx.stroke();
  }
  if (!name || !detail.placeLabels) return [];
  const px = textPx(view.scale, textM, 9, 20);
  // The name of a narrow box stands upright in it, as in `dray plant draw`.
  setFont(brush, px, 600);
  const upright = bottom - top > right - left && ctx.measureText(name).width > right - left - 4;
  const most = (upright ? bottom - top : right - left) - 4;
  const [x, y] = [(left + right) / 2, (top + bottom) / 2];
  const long = Math.min(most, ctx.measureText(name).width);
  ctx.save();
  ctx.translate(x, y);
  if (upright) ctx.rotate(-Math.PI / 2);
  write(brush, name, 0, 0, px, "steel-ink", most);
  ctx.restore();
  return [upright ? rectOfWords(x, y, long, px) : rectOfWords(x, y, px, long)];
}

function write(
  brush: Brush,
  text: string,
  x: number,
  y: number,
  px: number,
  colour: "steel-ink" | "ink-2",
  maxPx?: number,
): void {
  const { ctx, palette } = brush;
  setFont(brush, px, 600);
  ctx.fillStyle = palette[colour];
  ctx.textAlign = "center";
  ctx.textBaseline = "middle";
  ctx.fillText(text, x, y + px * 0.06, maxPx);
}
