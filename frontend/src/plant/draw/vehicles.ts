/** Vehicles: a disc with a nose, what it carries, its battery, and what is wrong with it. */
import type { AtvView } from "../../api/types";
import type { ShownVehicle } from "../../motion/fleet-motion";
import { type Rect, toScreenX, toScreenY } from "../surface/geometry";
import type { Brush } from "./brush";
import { traceBolt } from "./floor";
import { placesAround } from "./labels";
import type { Words } from "./words";

/** From the rim of a chosen vehicle to that of its halo. */
const HALO_PX = 6;
/** As many characters of a name as stand on the map; a longer one keeps its beginning, and its end, by which fleets count. */
const NAME_CHARS = 14;
const END_CHARS = 5;

export type Look = "chosen" | "alarm" | "lost" | "charging" | "idle" | "normal";

/** Who is silent looks silent, whatever it said last: that is a memory. */
export function lookOf(view: AtvView, chosen: boolean, lost: boolean): Look {
  if (lost) return "lost";
  if (view.status === "error" || view.status === "stopped") return "alarm";
  if (chosen) return "chosen";
  if (view.status === "charging" || view.status === "idle") return view.status;
  return "normal";
}

const BODY = {
  chosen: "chosen",
  alarm: "raised",
  lost: "lane",
  charging: "steel",
  idle: "floor",
  normal: "vehicle",
} as const;

/** Who is free is an empty ring; who is in trouble, a red one; who is silent, a broken red one. */
function rimOf(look: Look): "alarm" | "vehicle" | null {
  if (look === "alarm" || look === "lost") return "alarm";
  return look === "idle" ? "vehicle" : null;
}

/** Thousands of dots are quickest as one path per colour. */
export function drawDots(brush: Brush, vehicles: readonly ShownVehicle[], look: Look): void {
  const { ctx, view, palette, detail } = brush;
  if (vehicles.length === 0) return;
  const r = detail.vehiclePx;
  ctx.beginPath();
  for (const vehicle of vehicles) {
    const x = toScreenX(view, vehicle.x);
    const y = toScreenY(view, vehicle.y);
    ctx.moveTo(x + r, y);
    ctx.arc(x, y, r, 0, 2 * Math.PI);
  }
  ctx.fillStyle = palette[BODY[look]];
  ctx.fill();
  const rim = rimOf(look);
  if (!rim) return;
  ctx.strokeStyle = palette[rim];
  ctx.lineWidth = rim === "alarm" ? 2 : 1.25;
  ctx.stroke();
}

export function drawVehicle(brush: Brush, vehicle: ShownVehicle, look: Look, chosen: boolean, standby = false): void {
  const { ctx, view, palette, detail } = brush;
  const x = toScreenX(view, vehicle.x);
  const y = toScreenY(view, vehicle.y);
  const r = detail.vehiclePx;
  if (chosen) drawHalo(brush, x, y, r);
  else if (standby) drawStandby(brush, x, y, r);
  const rim = rimOf(look);
  const lost = look === "lost";
  if (!lost) drawBattery(brush, x, y, r, vehicle.view);
  drawNose(brush, x, y, r, vehicle.heading, palette[lost ? "lane-mark" : (rim ?? BODY[look])]);
  if (vehicle.view.link === "mesh" && !lost) drawRadio(brush, x, y, r + (chosen ? HALO_PX : 0));
  ctx.beginPath();
  ctx.arc(x, y, r, 0, 2 * Math.PI);
  ctx.fillStyle = palette[BODY[look]];
  ctx.fill();
  ctx.lineWidth = rim ? Math.max(2, r * 0.22) : Math.max(1, r * 0.14);
  ctx.strokeStyle = palette[rim ?? "floor"];
  // The ring of a silent one is broken: by its shape, too, it is no vehicle that reports a problem.
  if (lost) ctx.setLineDash([r * 0.42, r * 0.36]);
  ctx.stroke();
  ctx.setLineDash([]);
  if (lost) drawCross(brush, x, y, r);
  else drawInside(brush, x, y, r, vehicle.view, look);
}

function drawCross({ ctx, palette }: Brush, x: number, y: number, r: number): void {
  const arm = r * 0.36;
  ctx.beginPath();
  ctx.moveTo(x - arm, y - arm);
  ctx.lineTo(x + arm, y + arm);
  ctx.moveTo(x + arm, y - arm);
  ctx.lineTo(x - arm, y + arm);
  ctx.lineWidth = Math.max(1.5, r * 0.2);
  ctx.lineCap = "round";
  ctx.strokeStyle = palette.alarm;
  ctx.stroke();
  ctx.lineCap = "butt";
}

/** Two arcs at the shoulder: it speaks by radio only. */
function drawRadio({ ctx, palette }: Brush, x: number, y: number, rimPx: number): void {
  ctx.lineWidth = 2;
  ctx.lineCap = "round";
  ctx.strokeStyle = palette.warn;
  for (const awayPx of [4, 8]) {
    ctx.beginPath();
    ctx.arc(x, y, rimPx + awayPx, -0.36 * Math.PI, -0.14 * Math.PI);
    ctx.stroke();
  }
  ctx.lineCap = "butt";
}

/** Who would take over from the chosen one: a broken ring around it, in the colour of what is chosen. */
function drawStandby({ ctx, palette }: Brush, x: number, y: number, r: number): void {
  ctx.beginPath();
  ctx.arc(x, y, r + HALO_PX, 0, 2 * Math.PI);
  ctx.setLineDash([4, 4]);
  ctx.lineWidth = 2;
  ctx.strokeStyle = palette.chosen;
  ctx.stroke();
  ctx.setLineDash([]);
}

function drawHalo({ ctx, palette }: Brush, x: number, y: number, r: number): void {
  ctx.beginPath();
  ctx.arc(x, y, r + HALO_PX, 0, 2 * Math.PI);
  ctx.fillStyle = palette["chosen-soft"];
  ctx.fill();
  ctx.lineWidth = 2;
  ctx.strokeStyle = palette.chosen;
  ctx.stroke();
}

function drawNose(brush: Brush, x: number, y: number, r: number, heading: number, ink: string): void {
  const { ctx } = brush;
  const cos = Math.cos(heading);
  const sin = -Math.sin(heading);
  ctx.beginPath();
  ctx.moveTo(x + cos * r * 1.7, y + sin * r * 1.7);
  ctx.lineTo(x + (cos * 0.8 - sin * 0.66) * r, y + (sin * 0.8 + cos * 0.66) * r);
  ctx.lineTo(x + (cos * 0.8 + sin * 0.66) * r, y + (sin * 0.8 - cos * 0.66) * r);
  ctx.closePath();
  ctx.lineWidth = 2;
  ctx.lineJoin = "round";
  ctx.strokeStyle = brush.palette.floor;
  ctx.stroke();
  ctx.fillStyle = ink;
  ctx.fill();
}

/** One sign at a time, the most urgent first: trouble, charging, load. */
function drawInside(brush: Brush, x: number, y: number, r: number, view: AtvView, look: Look): void {
  const { ctx, palette } = brush;
  ctx.beginPath();
  if (view.status === "error") {
    ctx.fillStyle = palette.alarm;
    ctx.roundRect(x - r * 0.13, y - r * 0.58, r * 0.26, r * 0.68, r * 0.1);
    ctx.roundRect(x - r * 0.13, y + r * 0.28, r * 0.26, r * 0.26, r * 0.1);
  } else if (view.status === "stopped") {
    ctx.fillStyle = palette.alarm;
    ctx.rect(x - r * 0.45, y - r * 0.45, r * 0.3, r * 0.9);
    ctx.rect(x + r * 0.15, y - r * 0.45, r * 0.3, r * 0.9);
  } else if (view.status === "charging") {
    ctx.fillStyle = palette.floor;
    traceBolt(ctx, x, y, r * 0.62);
  } else if (view.load) {
    ctx.fillStyle = palette[look === "chosen" ? "on-chosen" : look === "idle" ? "vehicle" : "floor"];
    ctx.roundRect(x - r * 0.42, y - r * 0.42, r * 0.84, r * 0.84, r * 0.16);
  } else {
    return;
  }
  ctx.fill();
}

/** Only shown where it matters, or where there is room for it. */
function drawBattery(brush: Brush, x: number, y: number, r: number, view: AtvView): void {
  const low = view.battery_low;
  if (!low && r < 13 && view.status !== "charging") return;
  const { ctx, palette } = brush;
  const start = -Math.PI / 2;
  ctx.beginPath();
  ctx.arc(x, y, r + 2.5, start, start + 2 * Math.PI * view.battery_frac);
  ctx.lineWidth = Math.max(2, r * 0.16);
  ctx.strokeStyle = low ? palette.warn : palette.steel;
  ctx.stroke();
}

/**
 * Names beside the vehicles, where there is room. Where other words and machines leave none, whoever comes later in the
 * list stays without a name.
 */
export function namesOf(
  { detail, view }: Brush,
  vehicles: readonly { vehicle: ShownVehicle; look: Look; chosen: boolean; label: string }[],
): Words[] {
  return vehicles.map(({ chosen, label, look, vehicle }) => {
    const middle = { x: toScreenX(view, vehicle.x), y: toScreenY(view, vehicle.y) };
    return {
      text: label,
      px: detail.vehiclePx >= 11 ? 11.5 : 10,
      edgePx: 3,
      must: chosen,
      colour: look === "alarm" || look === "lost" ? "alarm" : chosen ? "chosen" : "ink-2",
      places: (size) => placesAround(middle, size, detail.vehiclePx + (chosen ? 8 : 5), chosen),
    };
  });
}

/** A vehicle's name as the map has room for it. */
export function shortName(name: string): string {
  return name.length <= NAME_CHARS ? name : `${name.slice(0, NAME_CHARS - END_CHARS - 1)}…${name.slice(-END_CHARS)}`;
}

/** What no name may cover of a vehicle: a little less than its disc, so that those beside one another keep theirs. */
export function discOf({ detail, view }: Brush, { x, y }: ShownVehicle): Rect {
  const half = 0.8 * detail.vehiclePx;
  const left = toScreenX(view, x) - half;
  const top = toScreenY(view, y) - half;
  return { left, top, right: left + 2 * half, bottom: top + 2 * half };
}
