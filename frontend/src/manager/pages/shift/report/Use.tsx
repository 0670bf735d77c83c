import { format, t } from "../../../../text/views/shift";
import type { Report } from "./shifts";

const PARTS = ["moving", "waiting", "charging", "idle", "blocked", "silent"] as const;

/** What the vehicles did, a column for each half hour; the same in words below it. */
export function Use({ report }: { report: Report }) {
  const { course, step_s } = report;
  if (course.length === 0) return null;
  const all = (part: (typeof PARTS)[number]): number => course.reduce((sum, point) => sum + (point[`${part}_frac`] ?? 0) * point.span_s, 0);
  const total = PARTS.reduce((sum, part) => sum + all(part), 0);
  return (
    <section>
      <h2>{t("shift.use")}</h2>
      <div class="shift-columns" aria-hidden="true">
        {course.map((point) => (
          <span key={point.at_s} title={`${format.hour(point.at_s)} – ${format.hour(point.at_s + step_s)}`}>
            <span class="shift-column">
              {PARTS.map((part) => (
                <i key={part} class={`use-${part}`} style={{ height: `${(point[`${part}_frac`] ?? 0) * 100}%` }} />
              ))}
            </span>
            <small>{format.hour(point.at_s)}</small>
          </span>
        ))}
      </div>
      <ul class="shift-legend">
        {PARTS.map((part) => (
          <li key={part}>
            <i class={`use-${part}`} /> {t(`kpis.${part}`)} <b>{total > 0 ? format.percent(all(part) / total, 1) : t("shift.unknown")}</b>
          </li>
        ))}
      </ul>
    </section>
  );
}
