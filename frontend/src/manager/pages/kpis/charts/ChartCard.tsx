import { useSignal } from "@preact/signals";
import type { KpiHistory } from "../../../../api/types";
import { Card } from "../../../../parts/Card";
import { format, t } from "../../../../text/views/records";
import type { Chart, Line } from "../charts";
import { type Column, columnOf, lastOf, stepsOf } from "../history";
import { FigureTable } from "./FigureTable";
import { Plot } from "./Plot";
import { shownValue } from "./shown";

/** A chart, the names and figures of its lines at the pointer or at the end, and its table. */
export function ChartCard({ chart, history }: { chart: Chart; history: KpiHistory }) {
  const at = useSignal<number | null>(null);
  const asTable = useSignal(false);
  const columns = chart.lines.map((line) => columnOf(history, line.figure));
  const steps = stepsOf(history);
  const atS = at.value === null ? undefined : steps[at.value];
  const title = t(`kpis.${chart.name}`);
  return (
    <Card
      title={title}
      class={`kpi-card kpi-${chart.name}`}
      aside={
        <>
          {atS !== undefined && <span class="muted">{format.moment(atS)}</span>}
          <button
            type="button"
            class="button small"
            aria-pressed={asTable.value}
            onClick={() => {
              asTable.value = !asTable.value;
            }}
          >
            {t(asTable.value ? "kpis.asChart" : "kpis.asTable")}
          </button>
        </>
      }
    >
      {asTable.value ? (
        <FigureTable chart={chart} steps={steps} columns={columns} title={title} />
      ) : (
        <Plot chart={chart} steps={steps} columns={columns} at={at} label={label(chart, columns, title)} />
      )}
      <ul class="kpi-legend">
        {chart.lines.map((line, i) => (
          <Entry key={line.name} chart={chart} line={line} value={valueAt(columns[i] ?? [], at.value)} />
        ))}
        {chart.mean && (
          <li>
            {t("kpis.mean")} <b>{shownValue(chart, chart.mean(history))}</b>
          </li>
        )}
      </ul>
    </Card>
  );
}

function Entry({ chart, line, value }: { chart: Chart; line: Line; value: number | null }) {
  const kind = chart.kind === "stack" ? (line.hatched === true ? "area kpi-mark-hatched" : "area") : line.dashed === true ? "dashed" : "plain";
  return (
    <li>
      <i class={`kpi-mark kpi-mark-${kind} ink-${line.ink}`} aria-hidden="true" />
      {t(`kpis.${line.name}`)} <b>{shownValue(chart, value)}</b>
    </li>
  );
}

function valueAt(column: Column, at: number | null): number | null {
  return at === null ? lastOf(column) : (column[at] ?? null);
}

/** What somebody is told who does not see the chart. */
function label(chart: Chart, columns: readonly Column[], title: string): string {
  const newest = chart.lines.map((line, i) => `${t(`kpis.${line.name}`)} ${shownValue(chart, lastOf(columns[i] ?? []))}`);
  return t("kpis.chartLabel", { title, newest: newest.join(", ") });
}
