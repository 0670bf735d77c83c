/** From metres on the floor (y up) to pixels on the screen (y down), and what lies under a finger. */
import type { Area, Box } from "../../api/types";

export interface Size {
  readonly width: number;
  readonly height: number;
}

/** A part of the floor, or all of it. */
export interface Region {
  readonly left_m: number;
  readonly bottom_m: number;
  readonly width_m: number;
  readonly height_m: number;
}

/** What d3-zoom keeps: scale 1 and no shift is the region that is shown at first, fitted. */
export interface Zoom {
  readonly k: number;
  readonly x: number;
  readonly y: number;
}

export interface View {
  /** Pixels per metre. */
  readonly scale: number;
  /** Pixels of the point (0 m, 0 m). */
  readonly x0: number;
  readonly y0: number;
}

export interface Rect {
  readonly left: number;
  readonly top: number;
  readonly right: number;
  readonly bottom: number;
}

/** The view in which a part of the floor fits, centred. */
export function fitView(region: Region, size: Size, pad: Rect): View {
  const width = Math.max(1, size.width - pad.left - pad.right);
  const height = Math.max(1, size.height - pad.top - pad.bottom);
  const scale = Math.min(width / region.width_m, height / region.height_m);
  return {
    scale,
    x0: pad.left + (width - region.width_m * scale) / 2 - region.left_m * scale,
    y0: pad.top + (height + region.height_m * scale) / 2 + region.bottom_m * scale,
  };
}

export function wholeOf({ height_m, width_m }: { height_m: number; width_m: number }): Region {
  return { left_m: 0, bottom_m: 0, width_m, height_m };
}

export function zoomed(fit: View, zoom: Zoom): View {
  return {
    scale: fit.scale * zoom.k,
    x0: fit.x0 * zoom.k + zoom.x,
    y0: fit.y0 * zoom.k + zoom.y,
  };
}

export function toScreenX(view: View, xM: number): number {
  return view.x0 + xM * view.scale;
}

export function toScreenY(view: View, yM: number): number {
  return view.y0 - yM * view.scale;
}

export function toFloorX(view: View, x: number): number {
  return (x - view.x0) / view.scale;
}

export function toFloorY(view: View, y: number): number {
  return (view.y0 - y) / view.scale;
}

/** The zoom that brings a point of the floor to the middle, at a scale of the fitted view. */
export function centredOn(fit: View, size: Size, point: { x: number; y: number }, k: number): Zoom {
  return {
    k,
    x: size.width / 2 - toScreenX(fit, point.x) * k,
    y: size.height / 2 - toScreenY(fit, point.y) * k,
  };
}

/** Whether a point of the floor is on the screen, and not at its very edge. */
export function isInSight(view: View, size: Size, point: { x: number; y: number }, marginPx: number): boolean {
  const [x, y] = [toScreenX(view, point.x), toScreenY(view, point.y)];
  return x >= marginPx && x <= size.width - marginPx && y >= marginPx && y <= size.height - marginPx;
}

export function boxOnScreen(view: View, box: Box): Rect {
  const x = toScreenX(view, box.x_m);
  const y = toScreenY(view, box.y_m);
  const w = (box.width_m * view.scale) / 2;
  const h = (box.depth_m * view.scale) / 2;
  return { left: x - w, top: y - h, right: x + w, bottom: y + h };
}

export function contains(rect: Rect, x: number, y: number, slack = 0): boolean {
  return (
    x >= rect.left - slack &&
    x <= rect.right + slack &&
    y >= rect.top - slack &&
    y <= rect.bottom + slack
  );
}

/** Whether a place on the floor is in an area. */
export function isInside(polygon: Area["polygon"], x_m: number, y_m: number): boolean {
  let inside = false;
  polygon.forEach((a, i) => {
    const b = polygon[(i + 1) % polygon.length] ?? a;
    const crosses = a.y_m > y_m !== b.y_m > y_m;
    if (crosses && x_m < a.x_m + ((y_m - a.y_m) * (b.x_m - a.x_m)) / (b.y_m - a.y_m)) inside = !inside;
  });
  return inside;
}

export function overlaps(a: Rect, b: Rect): boolean {
  return a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
}

/** A round length that takes about `targetPx` on the screen, for the scale bar. */
export function scaleBar(scale: number, targetPx: number): { metres: number; px: number } {
  const raw = targetPx / scale;
  const power = 10 ** Math.floor(Math.log10(raw));
  const metres = ([5, 2, 1].find((step) => step * power <= raw) ?? 1) * power;
  return { metres, px: metres * scale };
}
