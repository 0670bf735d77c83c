/** What people do to the draft, by pointer, key or button. */
import { t } from "../text/editor";
import { closedOrNot, moved, nearestLane, nodeById, removed, snapped, spotOf, withArea, withLane, withNode, withPlace, type Chosen, type PlaceSection, type Spot } from "./model";
import * as state from "./state";

/** So near the cursor is a lane that is closed by it. */
const CLOSE_WITHIN_M = 1.5;

type Act = { readonly kind: "move"; readonly dx_m: number; readonly dy_m: number } | { readonly kind: "remove" } | { readonly kind: "end" };

export const step_m = (fine: boolean): number => (fine ? 0.1 : state.grid_m.value);

export function act(what: Act): void {
  const chosen = state.chosen.value;
  const data = state.data.value;
  if (what.kind === "end") {
    if (state.tool.value === "areas") state.draw(withArea(data, state.begun.value.map(({ x_m, y_m }) => ({ x_m, y_m }))));
    state.begun.value = [];
    return;
  }
  if (!chosen) return;
  if (what.kind === "remove") {
    state.chosen.value = null;
    state.draw(removed(data, chosen));
    return;
  }
  const spot = spotOf(data, chosen);
  if (spot) state.draw(moved(data, chosen, { x_m: rounded(spot.x_m + what.dx_m), y_m: rounded(spot.y_m + what.dy_m) }));
}

const rounded = (value: number): number => Math.round(value * 1000) / 1000;

/** Use the chosen tool at a spot. */
export function atTool(at: Spot, within_m: number, hit: Chosen | null): void {
  const grid = state.grid_m.value;
  const spot = { x_m: snapped(at.x_m, grid), y_m: snapped(at.y_m, grid) };
  const data = state.data.value;
  const tool = state.tool.value;
  switch (tool) {
    case "choose":
      return;
    case "node":
      state.draw(withNode(data, spot, within_m)[0]);
      return;
    case "lane":
    case "road": {
      const [next, node] = withNode(data, spot, within_m);
      const first = state.begun.value[0]?.node;
      state.draw(first === undefined ? next : withLane(next, first, node, tool === "road"));
      // A lane ends where the next one may begin; the same node twice ends the row.
      const there = nodeById(state.data.value).get(node) ?? spot;
      state.begun.value = first === node ? [] : [{ x_m: there.x_m, y_m: there.y_m, node }];
      return;
    }
    case "areas": {
      const first = state.begun.value[0];
      if (first && state.begun.value.length > 2 && Math.hypot(first.x_m - spot.x_m, first.y_m - spot.y_m) <= within_m) act({ kind: "end" });
      else state.begun.value = [...state.begun.value, spot];
      return;
    }
    case "close": {
      const index = hit?.section === "lanes" ? hit.index : nearestLane(data, at, CLOSE_WITHIN_M);
      if (index >= 0) state.draw(closedOrNot(data, index));
      return;
    }
    default:
      state.draw(withPlace(data, tool satisfies PlaceSection, spot, within_m));
  }
}

/** Keys of the whole page, except where somebody writes. */
export function followKeys(): () => void {
  const onKey = (event: KeyboardEvent): void => {
    const target = event.target as HTMLElement;
    if (target.closest("input, textarea, select") || state.draft.value === null) return;
    const key = event.key.toLowerCase();
    if (event.ctrlKey || event.metaKey) {
      if (key === "z" && !event.shiftKey) state.undoOne();
      else if (key === "y" || (key === "z" && event.shiftKey)) state.redoOne();
      else return;
      event.preventDefault();
      return;
    }
    if (event.altKey) return;
    if (key === "delete" || key === "backspace") act({ kind: "remove" });
    else if (key === "escape") {
      state.begun.value = [];
      state.tool.value = "choose";
    } else if (key === "end") act({ kind: "end" });
    else {
      const tool = state.TOOLS.find((each) => state.KEYS[each].toLowerCase() === key);
      if (tool) choose(tool);
    }
  };
  addEventListener("keydown", onKey);
  return () => {
    removeEventListener("keydown", onKey);
  };
}

export function choose(tool: state.Tool): void {
  state.tool.value = tool;
  state.begun.value = [];
}

export const toolName = (tool: state.Tool): string => t(`tool.${tool}`);
