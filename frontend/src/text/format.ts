/** Numbers, times and lengths of time as people read them, by Intl and for one locale. */

export interface Formats {
  /** 0.974 -> 97.4 % */
  percent: (frac: number, digits?: number) => string;
  count: (value: number) => string;
  number: (value: number, digits: number) => string;
  /** 71 s, 3:40 min, 2:05 h, 12 d */
  duration: (seconds: number) => string;
  /** 54.8 s, 34:48 min: where tenths tell one from another */
  price: (seconds: number) => string;
  /** 0.4 s, 12 s, 3:40 min: how long ago */
  age: (seconds: number) => string;
  /** 10:39:20 */
  clock: (atS: number) => string;
  /** 10:39 */
  hour: (atS: number) => string;
  /** Fri 3 */
  day: (atS: number) => string;
  /** Fri 10:39 */
  moment: (atS: number) => string;
  /** Fri, 3 Dec 2031, 14:00 */
  dated: (atS: number) => string;
  /** Fri, 3 Dec 2031, 14:00 – 22:00 */
  span: (fromS: number, untilS: number) => string;
  /** 10:39 today, Fri 14:00 this week, 3 Dec 14:00 after it, 3 Dec 2031 14:00 in another year */
  due: (atS: number, nowS: number) => string;
  /** 10:39:20 today, Fri 14:00 this week, 3 Dec 14:00 before it, 3 Dec 2031 14:00 in another year */
  when: (atS: number, nowS: number) => string;
  list: (items: readonly string[]) => string;
}

const NARROW_SPACE = "\u202f";
/** From here on a length of time is easier to read in minutes. */
const MINUTES_FROM_S = 120;
const HOUR_S = 3600;
const DAY_S = 24 * HOUR_S;
/** From here on hours say nothing to anybody. */
const DAYS_FROM_S = 10 * DAY_S;
/** From here on a date may be of another year than one thinks. */
const YEAR_FROM_S = 300 * DAY_S;

export function formatsFor(locale: string, timeZone?: string): Formats {
  const zone = timeZone === undefined ? {} : { timeZone };
  const count = new Intl.NumberFormat(locale, { maximumFractionDigits: 0 });
  const tenths = new Intl.NumberFormat(locale, { minimumFractionDigits: 1, maximumFractionDigits: 1 });
  const clock = timeFormat(locale, { ...zone, hour: "2-digit", minute: "2-digit", second: "2-digit" });
  const hour = timeFormat(locale, { ...zone, hour: "2-digit", minute: "2-digit" });
  const weekday = timeFormat(locale, { ...zone, weekday: "short", hour: "2-digit", minute: "2-digit" });
  const date = timeFormat(locale, { ...zone, day: "numeric", month: "short", hour: "2-digit", minute: "2-digit" });
  const dateOfYear = timeFormat(locale, { ...zone, day: "numeric", month: "short", year: "numeric", hour: "2-digit", minute: "2-digit" });
  const dated = timeFormat(locale, { ...zone, weekday: "short", day: "numeric", month: "short", year: "numeric", hour: "2-digit", minute: "2-digit" });
  const dayOfMonth = timeFormat(locale, { ...zone, weekday: "short", day: "numeric" });
  const day = new Intl.DateTimeFormat("en-CA", { ...zone, dateStyle: "short" });
  const list = new Intl.ListFormat(locale, { type: "unit", style: "short" });
  const number = (value: number, digits: number): string =>
    digits === 1
      ? tenths.format(value)
      : new Intl.NumberFormat(locale, {
          minimumFractionDigits: digits,
          maximumFractionDigits: digits,
        }).format(value);
  const duration = (seconds: number): string => {
    const whole = Math.round(Math.abs(seconds));
    const sign = seconds < 0 && whole > 0 ? "−" : "";
    if (whole < MINUTES_FROM_S) return `${sign}${count.format(whole)}${NARROW_SPACE}s`;
    if (whole < 2 * HOUR_S) return `${sign}${minutes(whole)}${NARROW_SPACE}min`;
    if (whole < DAYS_FROM_S) return `${sign}${minutes(Math.round(whole / 60))}${NARROW_SPACE}h`;
    return `${sign}${count.format(Math.round(whole / DAY_S))}${NARROW_SPACE}d`;
  };
  const isSameDay = (atS: number, nowS: number): boolean => day.format(atS * 1000) === day.format(nowS * 1000);
  const otherDay = (atS: number, nowS: number): Intl.DateTimeFormat => {
    const awayS = Math.abs(atS - nowS);
    return awayS < 6 * DAY_S ? weekday : awayS < YEAR_FROM_S ? date : dateOfYear;
  };
  return {
    percent: (frac, digits = 0) => `${number(frac * 100, digits)}${NARROW_SPACE}%`,
    count: (value) => count.format(value),
    number,
    duration,
    price: (seconds) =>
      seconds < MINUTES_FROM_S ? `${tenths.format(seconds)}${NARROW_SPACE}s` : duration(seconds),
    age: (seconds) =>
      seconds < 10 ? `${tenths.format(Math.max(0, seconds))}${NARROW_SPACE}s` : duration(seconds),
    clock: (atS) => clock.format(atS * 1000),
    hour: (atS) => hour.format(atS * 1000),
    day: (atS) => dayOfMonth.format(atS * 1000),
    moment: (atS) => weekday.format(atS * 1000),
    dated: (atS) => dated.format(atS * 1000),
    span: (fromS, untilS) => dated.formatRange(fromS * 1000, untilS * 1000),
    due: (atS, nowS) => (isSameDay(atS, nowS) ? hour : otherDay(atS, nowS)).format(atS * 1000),
    when: (atS, nowS) => (isSameDay(atS, nowS) ? clock : otherDay(atS, nowS)).format(atS * 1000),
    list: (items) => list.format(items),
  };
}

/** Factories read a 24 hour clock, whatever the locale. */
function timeFormat(locale: string, options: Intl.DateTimeFormatOptions): Intl.DateTimeFormat {
  return new Intl.DateTimeFormat(locale, { ...options, hourCycle: "h23" });
}

function minutes(units: number): string {
  return `${Math.floor(units / 60)}:${String(units % 60).padStart(2, "0")}`;
}
