/** What every drawing function gets: where to draw, how, and how much. */
import type { Detail } from "./detail";
import type { Box } from "../../api/types";
import { boxOnScreen, overlaps, type Rect, type Size, type View } from "../surface/geometry";
import type { Palette } from "./palette";

export interface Brush {
  readonly ctx: CanvasRenderingContext2D;
  readonly size: Size;
  readonly view: View;
  readonly palette: Palette;
  readonly detail: Detail;
}

/** Whether any of it would be seen: with room for a frame around it. */
export function isInSight(brush: Brush, box: Box): boolean {
  return isOnScreen(brush, boxOnScreen(brush.view, box));
}

/** The same of what is in pixels already. */
export function isOnScreen({ size }: Brush, rect: Rect): boolean {
  const slack = 8;
  return overlaps(rect, { left: -slack, top: -slack, right: size.width + slack, bottom: size.height + slack });
}

/** A name that grows with the zoom between two readable bounds. */
export function textPx(scale: number, metres: number, least: number, most: number): number {
  return Math.round(Math.min(most, Math.max(least, metres * scale)) * 2) / 2;
}

export function setFont(brush: Brush, px: number, weight: number): void {
  brush.ctx.font = `${weight} ${px}px ${brush.palette.font}`;
}
