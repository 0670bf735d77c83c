/** Words on the map that are in nobody's box: each where it covers no other, measured and written. */
import type { Rect } from "../surface/geometry";
import { type Brush, setFont } from "./brush";
import { placed, type Taken, type Wish } from "./labels";
import type { Palette } from "./palette";

/** What is to be written, before it has a place. */
export interface Words {
  readonly text: string;
  readonly px: number;
  /** Width of the edge in the colour of the floor, by which letters stay legible on lines. */
  readonly edgePx: number;
  readonly colour: Exclude<keyof Palette, "font">;
  readonly must: boolean;
  /** @param size with the edge */
  readonly places: (size: { width: number; height: number }) => Wish["places"];
}

export function writeWords(brush: Brush, all: readonly Words[], taken: Taken): void {
  const { ctx, palette } = brush;
  const wishes = all.map(({ edgePx, must, places, px, text }) => {
    setFont(brush, px, 600);
    // As wide as it is drawn, with its rim: names differ in their letters.
    const size = { width: ctx.measureText(text).width + edgePx, height: px + 2 };
    return { ...size, must, places: places(size) };
  });
  ctx.textAlign = "center";
  ctx.textBaseline = "middle";
  ctx.lineJoin = "round";
  ctx.strokeStyle = palette.floor;
  placed(wishes, taken).forEach((rect, i) => {
    const words = all[i];
    if (!rect || !words) return;
    setFont(brush, words.px, 600);
    const [x, y] = [(rect.left + rect.right) / 2, (rect.top + rect.bottom) / 2];
    ctx.lineWidth = words.edgePx;
    ctx.strokeText(words.text, x, y);
    ctx.fillStyle = palette[words.colour];
    ctx.fillText(words.text, x, y);
  });
}

/** Where words stand that were written by their middle. */
export function rectOfWords(x: number, y: number, px: number, width: number): Rect {
  return { left: x - width / 2, right: x + width / 2, top: y - px / 2 - 1, bottom: y + px / 2 + 1 };
}
