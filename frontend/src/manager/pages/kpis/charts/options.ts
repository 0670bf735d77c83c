/** How uPlot draws a chart, in the colours of the page. */
import uPlot from "uplot";
import type { Palette } from "../../../../plant/draw/palette";
import { format } from "../../../../text/views/records";
import type { Chart, Line } from "../charts";
import { aloneIn, type Column, stacked } from "../history";
import { shownValue } from "./shown";

/** Longer ranges than this name the day. */
const DAY_S = 86_400;
const LABEL_PX = 12;
const HATCH_PX = 6;
/** A chart that is zoomed begins here, or below its lowest figure. */
const ZOOMED_FROM = 0.9;

/** The columns as uPlot takes them. A stack is drawn from the top down, each part over what is above it. */
export function dataOf(chart: Chart, steps: readonly number[], columns: readonly Column[]): uPlot.AlignedData {
  const drawn = chart.kind === "stack" ? stacked(columns).reverse() : columns;
  return [[...steps], ...drawn.map((column) => [...column])];
}

export function optionsOf(
  chart: Chart,
  palette: Palette,
  size: { width: number; height: number },
  point: (step: number | null) => void,
): uPlot.Options {
  const lines = chart.kind === "stack" ? [...chart.lines].reverse() : chart.lines;
  const font = `${LABEL_PX}px ${palette.font}`;
  const axis = { stroke: palette["ink-2"], font, ticks: { show: false }, border: { show: false } };
  return {
    ...size,
    legend: { show: false },
    padding: [8, 18, 0, 0],
    cursor: {
      y: false,
      drag: { x: false, y: false },
      points: { show: chart.kind !== "stack", size: 6 },
    },
    scales: { x: { time: true }, y: { range: rangeOf(chart) } },
    axes: [
      {
        ...axis,
        size: 30,
        // Clear of the 0 beside it, which is as low as the line.
        gap: 8,
        space: 72,
        grid: { show: false },
        values: (drawn, splits) => {
          const { min = 0, max = 0 } = drawn.scales.x ?? {};
          const long = max - min > DAY_S;
          return splits.map((atS) => (long ? format.day(atS) : format.hour(atS)));
        },
      },
      {
        ...axis,
        size: 60,
        gap: 6,
        space: 34,
        grid: { stroke: palette.line, width: 1 },
        values: (_drawn, splits) => splits.map((value) => axisValue(chart, value)),
      },
    ],
    bands: bandsOf(chart),
    series: [
      {},
      ...lines.map((line) => {
        // Shares of a few orders a day are far apart; a line between them is better than nothing.
        const spanGaps = line.figure === "on_time_frac";
        const { points, ...stroke } = strokeOf(chart, line, palette);
        return { ...stroke, spanGaps, points: { ...points, filter: dotsOf(spanGaps) } };
      }),
    ],
    hooks: {
      setCursor: [
        (drawn) => {
          point(drawn.cursor.idx ?? null);
        },
      ],
    },
  };
}

/**
 * Each part of a stack is filled down to the part below it, and not down to the axis: else a part of 0 % is drawn under all others, and shows at
 * both sides of each gap.
 */
export function bandsOf({ kind, lines }: Chart): uPlot.Band[] {
  return kind === "stack" ? lines.slice(1).map((_line, index) => ({ series: [index + 1, index + 2] })) : [];
}

/** A figure alone is a dot, as in the first minute; uPlot shows all as dots itself where there is room. */
function dotsOf(spans: boolean): uPlot.Series.Points.Filter {
  return (drawn, series, shown) => (shown ? null : aloneIn((drawn.data[series] ?? []) as Column, spans));
}

function strokeOf(chart: Chart, { dashed, hatched, ink }: Line, palette: Palette): uPlot.Series {
  const colour = palette[ink];
  const points = { size: 6, fill: colour };
  if (chart.kind === "stack") {
    const fill = hatched === true ? (drawn: uPlot): CanvasPattern | string => hatching(drawn.ctx, palette) : colour;
    // A rim between the parts: their greys are not far apart.
    return { fill, stroke: palette.panel, width: 1, points: { ...points, stroke: colour, show: false } };
  }
  const series: uPlot.Series = { stroke: colour, width: 1.75, points: { ...points, size: 4 } };
  if (dashed === true) series.dash = [5, 4];
  const steps = chart.kind === "steps" ? uPlot.paths.stepped?.({ align: 1 }) : undefined;
  if (steps) Object.assign(series, { paths: steps, points: { ...points, show: false } });
  return series;
}

/** As in the shift report: stripes of steel, an eighth of a turn. */
function hatching(on: CanvasRenderingContext2D, { panel, steel }: Palette): CanvasPattern | string {
  const size = Math.round(HATCH_PX * devicePixelRatio);
  const tile = Object.assign(document.createElement("canvas"), { width: size, height: size });
  const pen = tile.getContext("2d");
  if (!pen) return steel;
  pen.fillStyle = panel;
  pen.fillRect(0, 0, size, size);
  pen.strokeStyle = steel;
  pen.lineWidth = size / 3;
  // The same stripe in the tile's corners, so that tiles beside one another show no seam.
  for (const from of [-size, 0, size]) {
    pen.moveTo(from - size / 2, size * 1.5);
    pen.lineTo(from + size * 1.5, -size / 2);
  }
  pen.stroke();
  return on.createPattern(tile, "repeat") ?? steel;
}

/** From nothing to all, or to a little more than there is. */
function rangeOf(chart: Chart): uPlot.Range.Function {
  // Of nothing but gaps uPlot knows no bounds, whatever its types say: null counts as 0 here.
  return (_drawn, min, max) => {
    if (chart.zoomed === true) return [Math.min(ZOOMED_FROM, Math.floor(min * 10) / 10), 1];
    if (chart.unit === "percent") return [0, 1];
    return [0, Math.max(chart.unit === "duration" ? 10 : 4, max * 1.1)];
  };
}

function axisValue(chart: Chart, value: number): string {
  return chart.unit === "percent" ? format.percent(value) : shownValue(chart, value);
}
