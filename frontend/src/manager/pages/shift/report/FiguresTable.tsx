import { t, word } from "../../../../text/views/shift";
import { Explained } from "../../../../parts/Explained";
import { columnsOf } from "../../../../parts/stacked";
import { barOf, courseOf, type Figure, GROUPS, type Report } from "./shifts";
import { changeText, targetText, valueText } from "./value";

const WIDTH = 96;
const HEIGHT = 18;

/** Every figure with its target, what it was before and its course: one row each. */
export function FiguresTable({ report }: { report: Report }) {
  const named = new Map(report.figures.map((each) => [each.name, each]));
  let number = 0;
  const heads = [t("shift.figure"), t("shift.value"), t("shift.target"), "", t("shift.before"), t("shift.change"), t("shift.course")];
  return (
    <table class="shift-figures stacked" style={columnsOf(heads)}>
      <thead>
        <tr>
          <th scope="col">{t("shift.figure")}</th>
          <th scope="col" class="num">{t("shift.value")}</th>
          <th scope="col" class="num">{t("shift.target")}</th>
          <td aria-hidden="true" class="shift-wide" />
          <th scope="col" class="num">{t("shift.before")}</th>
          <th scope="col" class="num">{t("shift.change")}</th>
          <th scope="col" class="shift-wide">{t("shift.course")}</th>
        </tr>
      </thead>
      {(Object.keys(GROUPS) as (keyof typeof GROUPS)[]).map((group) => (
        <tbody key={group}>
          <tr>
            <th scope="rowgroup" colSpan={7} class="shift-group">{word("shift.group", group)}</th>
          </tr>
          {GROUPS[group].map((name) => {
            const figure = named.get(name);
            number += 1;
            return figure && <Row key={name} figure={figure} number={number} report={report} />;
          })}
        </tbody>
      ))}
    </table>
  );
}

function Row({ figure, number, report }: { figure: Figure; number: number; report: Report }) {
  const bar = barOf(figure);
  return (
    <tr class={figure.missed ? "shift-missed" : ""}>
      <th scope="row">
        <Explained says={word("shift.def", figure.name)}>
          {(about) => (
            <span class="term" tabIndex={0} {...about}>
              {word("shift.f", figure.name)}
            </span>
          )}
        </Explained>
        <sup>{number}</sup>
      </th>
      <td class="num shift-value">
        {figure.missed && <span class="tone-warn">▲ {t("shift.missed")} </span>}
        {valueText(figure.unit, figure.value)}
      </td>
      <td class={compared(figure.target)}>{targetText(figure)}</td>
      <td aria-hidden="true" class="shift-wide">
        {bar && (
          <span class="shift-bar">
            <i style={{ width: `${bar.value * 100}%` }} />
            {bar.target !== null && <b style={{ left: `${bar.target * 100}%` }} />}
          </span>
        )}
      </td>
      <td class={compared(figure.before)}>{valueText(figure.unit, figure.before)}</td>
      <td class={compared(figure.value === null ? null : figure.before)}>{changeText(figure)}</td>
      <td aria-hidden="true" class="shift-wide">
        <Course values={courseOf(report, figure.name)} />
      </td>
    </tr>
  );
}

/** A cell that has nothing to compare with takes no line where cells stand below one another. */
function compared(value: number | null): string {
  return value === null ? "num shift-nothing" : "num";
}

function Course({ values }: { values: readonly number[] }) {
  if (values.length < 2) return null;
  const most = Math.max(...values);
  const points = values.map((each, i) => [(i * WIDTH) / (values.length - 1), most > 0 ? HEIGHT * (1 - each / most) : HEIGHT]);
  return (
    <svg width={WIDTH + 4} height={HEIGHT + 4} viewBox={`-2 -2 ${WIDTH + 4} ${HEIGHT + 4}`}>
      <polyline points={points.map((point) => point.join(",")).join(" ")} class="spark-line" />
    </svg>
  );
}
