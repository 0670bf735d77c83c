/** A calendar of recurring work in words. */
import { format, n, t } from "../../../text/views/recurring";
import { dayName } from "./draft";
import { DAYS, type Every, type Rhythm, rhythmOf } from "./rhythm";

/** As many in a row are told by the first and the last of them. */
const ROW = 3;

/** A sentence for an expression of cron; null where only the expression itself can tell it. */
export function calendarText(expression: string, language: string): string | null {
  const rhythm = rhythmOf(expression);
  if (rhythm === null) return null;
  const days = daysText(rhythm, language);
  const { every, months } = rhythm;
  const told =
    every === null
      ? t("recurring.daysAt", { days, time: format.list(rhythm.timesMin.map(clock)) })
      : t("recurring.daysEvery", { days, every: everyText(every) });
  if (months.length === 0) return told;
  const names = spans(months, (month) => month - 1).map(([first, last]) => spanText(monthName(first, language), monthName(last, language)));
  return t("recurring.inMonths", { when: told, months: format.list(names) });
}

function daysText({ dates, days }: Rhythm, language: string): string {
  if (dates.length > 0) {
    const shown = format.list(dates.map((date) => t("recurring.date", { date })));
    return t(dates.length === 1 ? "recurring.onDate" : "recurring.onDates", { dates: shown });
  }
  if (days.length === 0) return t("recurring.everyDay");
  const week: readonly string[] = DAYS;
  return format.list(spans(days, (day) => week.indexOf(day)).map(([first, last]) => spanText(dayName(first, language), dayName(last, language))));
}

function everyText({ allDay, firstMin, lastMin, stepMin }: Every): string {
  const step = stepMin % 60 === 0 ? n("recurring.everyHours", stepMin / 60) : n("recurring.everyMinutes", stepMin);
  return allDay ? step : t("recurring.everyFrom", { every: step, first: clock(firstMin), last: clock(lastMin) });
}

/** What follows one another, as its first and its last; too few of them each by itself. */
function spans<T>(all: readonly T[], place: (each: T) => number): [T, T][] {
  const rows: T[][] = [];
  for (const each of all) {
    const row = rows.at(-1);
    const before = row?.at(-1);
    if (row && before !== undefined && place(each) === place(before) + 1) row.push(each);
    else rows.push([each]);
  }
  return rows.flatMap((row): [T, T][] => {
    const [first, last] = [row[0], row.at(-1)];
    return row.length >= ROW && first !== undefined && last !== undefined ? [[first, last]] : row.map((each) => [each, each]);
  });
}

function spanText(first: string, last: string): string {
  return first === last ? first : t("recurring.fromTo", { first, last });
}

function clock(ofDayMin: number): string {
  return [Math.floor(ofDayMin / 60), ofDayMin % 60].map((each) => String(each).padStart(2, "0")).join(":");
}

function monthName(month: number, language: string): string {
  return new Intl.DateTimeFormat(language, { month: "long", timeZone: "UTC" }).format(new Date(Date.UTC(1970, month - 1, 1)));
}
