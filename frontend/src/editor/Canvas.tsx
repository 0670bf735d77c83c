/** The floor of the draft: drawn with the pointer, or with the keyboard and a cursor. */
import { useSignal } from "@preact/signals";
import { useEffect, useMemo, useRef } from "preact/hooks";
import { t } from "../text/editor";
import { act, atTool, step_m } from "./acts";
import { Floor } from "./Floor";
import { moved, nearestNode, type Data, type Spot } from "./model";
import * as state from "./state";

const MARGIN_M = 2;

interface View extends Spot {
  readonly width_m: number;
}

export function Canvas() {
  const svg = useRef<SVGSVGElement>(null);
  const data = state.data.value;
  const [width_m, height_m] = [side(data, "width_m"), side(data, "height_m")];
  const whole = useMemo<View>(() => ({ x_m: -MARGIN_M, y_m: -MARGIN_M, width_m: width_m + 2 * MARGIN_M }), [width_m]);
  const view = useSignal<View>(whole);
  useEffect(() => {
    view.value = whole;
  }, [view, whole]);
  const drag = useRef<Drag | null>(null);
  const { x_m, y_m, width_m: seen_m } = view.value;
  const ratio = (height_m + 2 * MARGIN_M) / (width_m + 2 * MARGIN_M);
  const unit_m = seen_m / 900;

  const spotAt = (event: PointerEvent): Spot => {
    const matrix = svg.current?.getScreenCTM()?.inverse();
    const point = new DOMPoint(event.clientX, event.clientY).matrixTransform(matrix);
    return { x_m: point.x, y_m: height_m - point.y };
  };
  const zoom = (by: number, around: Spot = { x_m: x_m + seen_m / 2, y_m: y_m + (seen_m * ratio) / 2 }): void => {
    const next_m = Math.min(Math.max(seen_m * by, 5), whole.width_m * 2);
    const part = next_m / seen_m;
    view.value = { x_m: around.x_m - (around.x_m - x_m) * part, y_m: around.y_m - (around.y_m - y_m) * part, width_m: next_m };
  };

  const onDown = (event: PointerEvent): void => {
    const spot = spotAt(event);
    svg.current?.setPointerCapture(event.pointerId);
    const hit = (event.target as Element).closest<SVGElement>("[data-section]");
    if (state.tool.value === "choose") {
      state.chosen.value = hit ? chosenAt(hit) : null;
      drag.current = { from: spot, view: view.value, data: hit ? data : null, moved: false };
    } else {
      state.cursor.value = spot;
      atTool(spot, seen_m / 60, hit ? chosenAt(hit) : null);
      drag.current = null;
    }
  };
  const onMove = (event: PointerEvent): void => {
    const spot = spotAt(event);
    const now = drag.current;
    if (!now) {
      state.cursor.value = spot;
      return;
    }
    const far = Math.hypot(spot.x_m - now.from.x_m, spot.y_m - now.from.y_m) > unit_m * 5;
    if (!far && !now.moved) return;
    now.moved = true;
    const chosen = state.chosen.value;
    if (now.data && chosen) {
      const grid = state.grid_m.value;
      state.ghost.value = moved(now.data, chosen, { x_m: snap(spot.x_m, grid), y_m: snap(spot.y_m, grid) });
    } else if (!now.data) {
      view.value = { ...now.view, x_m: view.value.x_m - (spot.x_m - now.from.x_m), y_m: view.value.y_m + (spot.y_m - now.from.y_m) };
    }
  };
  const onUp = (): void => {
    if (state.ghost.value) state.draw(state.ghost.value);
    state.ghost.value = null;
    drag.current = null;
  };

  const onKey = (event: KeyboardEvent): void => {
    const by = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (by && !event.ctrlKey && !event.metaKey) {
      const [dx = 0, dy = 0] = by;
      const wide_m = step_m(event.altKey);
      if (event.shiftKey && state.chosen.value) act({ kind: "move", dx_m: dx * wide_m, dy_m: dy * wide_m });
      else state.cursor.value = { x_m: snap(state.cursor.value.x_m, wide_m) + dx * wide_m, y_m: snap(state.cursor.value.y_m, wide_m) + dy * wide_m };
      event.preventDefault();
    } else if (event.key === "Enter" || event.key === " ") {
      if (state.tool.value === "choose") chooseNear(state.cursor.value);
      else atTool(state.cursor.value, 0.6, null);
      event.preventDefault();
    } else if (event.key === "+" || event.key === "-") {
      zoom(event.key === "+" ? 0.8 : 1.25);
      event.preventDefault();
    }
  };

  return (
    <div class="ed-canvas">
      <svg
        ref={svg}
        tabindex={0}
        role="application"
        aria-label={t("canvas.label")}
        aria-describedby="ed-how"
        viewBox={`${x_m} ${y_m} ${seen_m} ${seen_m * ratio}`}
        onPointerDown={onDown}
        onPointerMove={onMove}
        onPointerUp={onUp}
        onKeyDown={onKey}
        onWheel={(event) => {
          event.preventDefault();
          const spot = spotAt(event as unknown as PointerEvent);
          zoom(event.deltaY > 0 ? 1.15 : 0.87, { x_m: spot.x_m, y_m: height_m - spot.y_m });
        }}
      >
        <Floor width_m={width_m} height_m={height_m} unit_m={unit_m} />
      </svg>
      <div class="ed-zoom">
        <button type="button" class="button" aria-label={t("canvas.out")} onClick={() => { zoom(1.25); }}>−</button>
        <button type="button" class="button" aria-label={t("canvas.in")} onClick={() => { zoom(0.8); }}>+</button>
        <button type="button" class="button" onClick={() => { view.value = whole; }}>{t("canvas.whole")}</button>
      </div>
    </div>
  );
}

interface Drag {
  readonly from: Spot;
  readonly view: View;
  /** What was drawn when something was taken; null where the floor itself is moved. */
  readonly data: Data | null;
  moved: boolean;
}

const snap = (value: number, grid: number): number => Math.round(Math.round(value / grid) * grid * 1000) / 1000;

const side = (data: Data, name: string): number => {
  const value = data[name];
  return typeof value === "number" && value > 0 && value <= 10_000 ? value : 60;
};

function chosenAt(hit: SVGElement) {
  const [section, index] = [hit.dataset.section ?? "", Number(hit.dataset.index)];
  return { section: section as never, index };
}

function chooseNear(spot: Spot): void {
  const node = nearestNode(state.data.value, spot, 1.5);
  const list = (state.data.value.nodes ?? []) as { id: string }[];
  state.chosen.value = node ? { section: "nodes", index: list.findIndex(({ id }) => id === node.id) } : null;
}
