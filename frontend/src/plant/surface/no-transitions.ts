/**
 * Stands in for d3-transition and d3-interpolate, which d3-zoom asks for: the map moves at once, so nothing has to be interrupted
 * or interpolated. With them go d3-ease, d3-timer and d3-color, a tenth of the first script (`vite.config.ts`).
 */
import { selection } from "d3-selection";

/** Nothing goes on that could be interrupted. */
export function interrupt(): void {
  return;
}

/** What d3-zoom would do between two looks in a transition. */
export function interpolateZoom(): never {
  throw new Error("the map has no transitions: move it at once, or take d3-transition back into vite.config.ts");
}

Object.assign(selection.prototype, {
  interrupt(this: unknown) {
    return this;
  },
});
