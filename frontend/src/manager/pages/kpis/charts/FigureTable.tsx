import { format, t } from "../../../../text/views/records";
import type { Chart } from "../charts";
import type { Column } from "../history";
import { shownValue } from "./shown";

interface Props {
  chart: Chart;
  steps: readonly number[];
  columns: readonly Column[];
  title: string;
}

/** The figures of a chart, the newest first; steps of which nothing is known are left out. */
export function FigureTable({ chart, columns, steps, title }: Props) {
  const known = steps.map((_, i) => i).filter((i) => columns.some((column) => column[i] != null));
  return (
    <div class="kpi-table" tabIndex={0} role="group" aria-label={title}>
      <table>
        <thead>
          <tr>
            <th scope="col">{t("kpis.at")}</th>
            {chart.lines.map((line) => (
              <th key={line.name} scope="col">
                {t(`kpis.${line.name}`)}
              </th>
            ))}
          </tr>
        </thead>
        <tbody>
          {known.reverse().map((i) => (
            <tr key={steps[i]}>
              <th scope="row">{format.moment(steps[i] ?? 0)}</th>
              {columns.map((column, j) => (
                <td key={j} class="num">
                  {shownValue(chart, column[i] ?? null)}
                </td>
              ))}
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}
