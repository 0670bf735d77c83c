import { factorySeconds, factoryTime } from "../../../../text/plant-time";
import { format, t, word } from "../../../../text/views/shift";
import type { Figure, Report, Shift } from "./shifts";
import { valueText } from "./value";

/** Parts of a time that are missed by less are what a minute is late. */
const ALL_SEEN_FRAC = 0.98;

/** Which shift it is, and three sentences: result, what happened, what to look at. */
export function Head({ report, shift }: { report: Report; shift: Shift }) {
  const named = new Map(report.figures.map((each) => [each.name, each]));
  const count = (name: string): string => valueText("count", named.get(name)?.value ?? null);
  const { period } = report;
  return (
    <header class="shift-head">
      <h1>
        {t("shift.title")} <span>{word("shift.name", shift.name)}, {format.span(shift.fromS, shift.untilS)}</span>
      </h1>
      <p class="muted">{t("shift.made", { plant: report.plant, at: format.dated(report.made_at_s), zone: Intl.DateTimeFormat().resolvedOptions().timeZone })}</p>
      {period.until_at_s < shift.untilS && <p class="shift-note">{t("shift.goesOn", { at: format.hour(period.until_at_s) })}</p>}
      {period.seen_frac < ALL_SEEN_FRAC && <p class="shift-note tone-warn">{t("shift.seen", { part: partText(period.seen_frac) })}</p>}
      {report.before.seen_frac < ALL_SEEN_FRAC && <p class="shift-note">{beforeText(report.before.seen_frac)}</p>}
      <ul class="shift-said">
        <li>
          <b>
            {named.get("orders_delivered")?.value === 0
              ? t("shift.head.noOrders")
              : t("shift.head.orders", { n: count("orders_delivered"), part: valueText("frac", named.get("on_time_frac")?.value ?? null) })}
          </b>
          {t("shift.head.late", { late: count("orders_late"), open: count("orders_open"), overdue: count("orders_overdue") })}
        </li>
        <li>
          <b>{t("shift.head.happened", { takeovers: count("takeovers"), interventions: count("interventions") })}</b>
          {t("shift.head.helps", { helps: count("helps") })}
        </li>
        <LookAt report={report} missed={report.figures.find((each) => each.missed)} />
      </ul>
    </header>
  );
}

function LookAt({ missed, report }: { missed: Figure | undefined; report: Report }) {
  const wait = report.waits[0];
  const longest = wait && t("shift.head.wait", { agent: wait.agent, other: wait.other, time: factoryTime(factorySeconds(wait.until_at_s - wait.from_at_s)) });
  if (missed) {
    return (
      <li>
        <b>{t("shift.head.missed", { what: word("shift.f", missed.name) })}</b>
        {t("shift.head.missedBy", { value: valueText(missed.unit, missed.value), target: valueText(missed.unit, missed.target) })} {longest}
      </li>
    );
  }
  const hasTargets = report.figures.some((each) => each.target !== null);
  return (
    <li>
      <b>{t(hasTargets ? "shift.head.fine" : "shift.head.noTargets")}</b>
      {longest}
    </li>
  );
}

/** How much is known of what it is compared with. */
function beforeText(seenFrac: number): string {
  return seenFrac > 0 ? t("shift.seenBefore", { part: partText(seenFrac) }) : t("shift.noneBefore");
}

/** A small part is told in tenths: it is not nothing. */
function partText(frac: number): string {
  return format.percent(frac, frac > 0 && frac < 0.01 ? 1 : 0);
}
