/** Which part of the floor an operator sees. Pure. */
import type { Area, MachineSpec } from "../../api/types";
import { isInside, type Region } from "../../plant/surface/geometry";

/** The box around all of these areas; null without any. */
export function regionOf(areas: readonly Area[]): Region | null {
  const corners = areas.flatMap((area) => area.polygon);
  if (corners.length === 0) return null;
  const xs = corners.map((corner) => corner.x_m);
  const ys = corners.map((corner) => corner.y_m);
  const [left_m, bottom_m] = [Math.min(...xs), Math.min(...ys)];
  return { left_m, bottom_m, width_m: Math.max(...xs) - left_m, height_m: Math.max(...ys) - bottom_m };
}

/** The area around a place; on a common border the first one. */
export function areaAt(areas: readonly Area[], x_m: number, y_m: number): Area | undefined {
  return areas.find(({ polygon }) => isInside(polygon, x_m, y_m));
}

/** In a straight line: people walk where vehicles do not drive. */
export function distanceM(machine: Pick<MachineSpec, "box">, atv: { x_m: number; y_m: number }): number {
  return Math.hypot(machine.box.x_m - atv.x_m, machine.box.y_m - atv.y_m);
}
