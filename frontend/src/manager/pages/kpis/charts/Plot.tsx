import type { Signal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import uPlot from "uplot";
import { colours } from "../../../../theme/theme";
import { readPalette } from "../../../../plant/draw/palette";
import type { Chart } from "../charts";
import type { Column } from "../history";
import { stepFor } from "./keys";
import { dataOf, optionsOf } from "./options";

const HEIGHT_PX = 168;

interface Props {
  chart: Chart;
  steps: readonly number[];
  columns: readonly Column[];
  /** The step that is pointed at. */
  at: Signal<number | null>;
  label: string;
}

/** A chart on a canvas. Arrow keys move the pointer; nothing in it moves by itself. */
export function Plot({ at, chart, columns, label, steps }: Props) {
  const box = useRef<HTMLDivElement>(null);
  const plot = useRef<uPlot | null>(null);
  const data = dataOf(chart, steps, columns);
  const newest = useRef(data);
  newest.current = data;
  const colour = colours.value;
  useEffect(() => {
    const element = box.current;
    if (!element) return;
    const palette = readPalette(element);
    const drawn = new uPlot(
      optionsOf(chart, palette, { width: element.clientWidth, height: HEIGHT_PX }, (step) => {
        at.value = step;
      }),
      newest.current,
      element,
    );
    plot.current = drawn;
    const fit = new ResizeObserver(() => {
      drawn.setSize({ width: element.clientWidth, height: HEIGHT_PX });
    });
    fit.observe(element);
    return () => {
      fit.disconnect();
      drawn.destroy();
    };
  }, [at, chart, colour]);
  useEffect(() => {
    plot.current?.setData(newest.current);
  }, [columns]);
  const point = (step: number | null): void => {
    const drawn = plot.current;
    const atS = step === null ? undefined : steps[step];
    const left = atS === undefined ? -10 : (drawn?.valToPos(atS, "x") ?? -10);
    drawn?.setCursor({ left, top: left < 0 ? -10 : HEIGHT_PX / 3 });
    at.value = step;
  };
  return (
    <div
      ref={box}
      class="kpi-plot"
      role="img"
      aria-label={label}
      tabIndex={0}
      onKeyDown={(event) => {
        const to = stepFor(event.key, at.peek(), steps.length);
        if (to === undefined) return;
        event.preventDefault();
        point(to);
      }}
      onBlur={() => {
        point(null);
      }}
    />
  );
}
