/** What every drawing function gets: where to draw, how, and how much. */
import type { Detail } from "../detail";
import type { View } from "../geometry";
import type { Palette } from "../palette";

export interface Brush {
  readonly ctx: CanvasRenderingContext2D;
  readonly view: View;
  readonly palette: Palette;
  readonly detail: Detail;
}

/** A name that grows with the zoom between two readable bounds. */
export function textPx(scale: number, metres: number, least: number, most: number): number {
  return Math.round(Math.min(most, Math.max(least, metres * scale)) * 2) / 2;
}

export function setFont(brush: Brush, px: number, weight: number): void {
  brush.ctx.font = `${weight} ${px}px ${brush.palette.font}`;
}
