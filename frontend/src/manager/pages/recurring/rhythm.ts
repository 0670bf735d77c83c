/** A cron expression as its days and its times of day, as the gateway reads it. */

/** As cron counts them, in the order of a week here. */
export const DAYS = ["1", "2", "3", "4", "5", "6", "0"] as const;

/** Times of day of which each is named; of more, only how far they are apart. */
const MOST_TIMES = 4;
/** Days of a month that are named. */
const MOST_DATES = 4;
/** Each month has the days up to this one. */
const LAST_DATE = 28;
const DAY_MIN = 24 * 60;
/** What a year and a week have of each. */
const MONTHS = 12;

const MONTH_NAMES = ["JAN", "FEB", "MAR", "APR", "MAY", "JUN", "JUL", "AUG", "SEP", "OCT", "NOV", "DEC"];
const DAY_NAMES = ["SUN", "MON", "TUE", "WED", "THU", "FRI", "SAT"];

export interface Rhythm {
  /** Days of the week in the order of `DAYS`; empty for all of them. */
  readonly days: readonly string[];
  /** Days of the month, from 1; empty for all of them. With some, `days` is empty. */
  readonly dates: readonly number[];
  /** Months, from 1; empty for all of them. */
  readonly months: readonly number[];
  /** Times of day in minutes; empty where `every` tells them. */
  readonly timesMin: readonly number[];
  readonly every: Every | null;
}

/** Times that are equally far apart, within each day. */
export interface Every {
  readonly stepMin: number;
  readonly firstMin: number;
  readonly lastMin: number;
  /** Whether it goes on over midnight in the same steps. */
  readonly allDay: boolean;
}

/** What an expression comes to; null for one that a short sentence cannot tell. */
export function rhythmOf(expression: string): Rhythm | null {
  const [minute = "", hour = "", date = "", month = "", day = "", ...more] = expression.trim().toUpperCase().split(/\s+/);
  // Cron takes either, where a day of the month and one of the week are given.
  if (more.length > 0 || (date !== "*" && day !== "*")) return null;
  const minutes = valuesOf(minute, 0, 59);
  const hours = valuesOf(hour, 0, 23);
  const dates = valuesOf(date, 1, 31);
  const months = valuesOf(month, 1, MONTHS, MONTH_NAMES);
  const days = valuesOf(day, 0, 7, DAY_NAMES);
  if (!minutes || !hours || !dates || !months || !days) return null;
  if (date !== "*" && (dates.length > MOST_DATES || dates.some((each) => each > LAST_DATE))) return null;
  const times = timesOf(hours.flatMap((each) => minutes.map((past) => each * 60 + past)));
  if (times === null) return null;
  const week = DAYS.filter((each) => days.includes(Number(each)) || (each === "0" && days.includes(7)));
  return {
    days: week.length === DAYS.length ? [] : week,
    dates: date === "*" ? [] : dates,
    months: months.length === MONTHS ? [] : months,
    ...times,
  };
}

/** The times of a day, in their order: some by themselves, or how far all of them are apart. */
function timesOf(timesMin: readonly number[]): Pick<Rhythm, "timesMin" | "every"> | null {
  if (timesMin.length <= MOST_TIMES) return { timesMin, every: null };
  const [firstMin = 0, secondMin = 0] = timesMin;
  const lastMin = timesMin.at(-1) ?? 0;
  const stepMin = secondMin - firstMin;
  if (timesMin.some((each, i) => each !== firstMin + i * stepMin)) return null;
  return { timesMin: [], every: { stepMin, firstMin, lastMin, allDay: firstMin === 0 && lastMin + stepMin === DAY_MIN } };
}

/** The numbers that a field stands for, in their order; null for what is no list of numbers, ranges and steps. */
function valuesOf(field: string, least: number, most: number, names: readonly string[] = []): number[] | null {
  const found = new Set<number>();
  for (const part of field.split(",")) {
    const [, from = "", to, by] = /^(\*|\w+)(?:-(\w+))?(?:\/(\d+))?$/.exec(part) ?? [];
    const first = from === "*" ? least : numberOf(from, least, names);
    const end = from === "*" ? most : numberOf(to ?? from, least, names);
    // With a step, a single number goes on to the end of the field, also as a range of itself: 6/2 and 6-6/2.
    const last = by !== undefined && end === first ? most : end;
    const step = Number(by ?? 1);
    if (first === null || last === null || step < 1 || first < least || last > most || first > last) return null;
    if (from === "*" && to !== undefined) return null;
    for (let each = first; each <= last; each += step) found.add(each);
  }
  return [...found].sort((one, other) => one - other);
}

function numberOf(word: string, least: number, names: readonly string[]): number | null {
  if (/^\d+$/.test(word)) return Number(word);
  const at = names.indexOf(word);
  return at < 0 ? null : at + least;
}
