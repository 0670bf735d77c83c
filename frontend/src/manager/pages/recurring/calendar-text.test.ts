import { afterAll, describe, expect, test } from "vitest";
import "../../../text/in-english";
import { en } from "../../../text/manager/en";
import { speak } from "../../../text/speech";
import { recurring as de } from "../../../text/views/recurring/de";
import { recurring } from "../../../text/views/recurring/en";
import { recurring as es } from "../../../text/views/recurring/es";
import { calendarText } from "./calendar-text";
import { DAYS } from "./rhythm";
import { rhythmOf } from "./rhythm";

afterAll(() => { speak("en", { ...en, ...recurring }, "en-GB"); });

describe("in English", () => {
  test.each([
    ["0 6 * * 1-5", "Mon to Fri at 06:00"],
    ["0 6 * * MON-FRI", "Mon to Fri at 06:00"],
    ["45 5 * * 3,1", "Mon, Wed at 05:45"],
    ["0 22 * * *", "every day at 22:00"],
    ["0 22 * * 0-6", "every day at 22:00"],
    ["0 6,14,22 * * 6,7", "Sat, Sun at 06:00, 14:00, 22:00"],
    ["0 6 * * 1-4,6", "Mon to Thu, Sat at 06:00"],
    ["*/30 6-21 * * 1-5", "Mon to Fri, every 30 minutes from 06:00 to 21:30"],
    ["*/30 * * * *", "every day, every 30 minutes"],
    ["* * * * *", "every day, every minute"],
    ["0 * * * *", "every day, every hour"],
    ["15 * * * *", "every day, every hour from 00:15 to 23:15"],
    ["0 */2 * * 1", "Mon, every 2 hours"],
    ["0 6-6/2 * * *", "every day, every 2 hours from 06:00 to 22:00"],
    ["0 6 * * 1-1/3", "Mon, Thu, Sun at 06:00"],
    ["5-5/10 6 * * *", "every day, every 10 minutes from 06:05 to 06:55"],
    ["0 6 * MAR-MAR/4 *", "every day at 06:00, only in March, July, November"],
    ["0 6 1 * *", "on day 1 of each month at 06:00"],
    ["0 6 1,15 * *", "on days 1, 15 of each month at 06:00"],
    ["0 6 24 12 *", "on day 24 of each month at 06:00, only in December"],
    ["0 6 * JUN-AUG,12 1", "Mon at 06:00, only in June to August, December"],
  ])("%s is “%s”", (expression, told) => {
    expect(calendarText(expression, "en")).toBe(told);
  });
});

test.each([
  ["de", "de-DE", de, "0 6 * * 1-5", "Mo bis Fr um 06:00"],
  ["de", "de-DE", de, "*/30 6-21 * * *", "jeden Tag, alle 30 Minuten von 06:00 bis 21:30"],
  ["de", "de-DE", de, "0 6 1,15 3 *", "am 1., 15. jedes Monats um 06:00, nur im März"],
  ["es", "es-ES", es, "0 6 * * 1-5", "lun a vie a las 06:00"],
  ["es", "es-ES", es, "*/30 6-21 * * *", "todos los días, cada 30 minutos de 06:00 a 21:30"],
  ["es", "es-ES", es, "0 6 1,15 3 *", "los días 1 y 15 de cada mes a las 06:00, solo en marzo"],
] as const)("in %s", (language, locale, table, expression, told) => {
  speak(language, { ...en, ...table }, locale);
  expect(calendarText(expression, language)).toBe(told);
});

test.each([
  "*/7 * * * *", "0 6,7,9,12,20 * * *", "0 22-23,0-3 * * *", "0 6 31 * *", "0 6 */2 * *", "0 6 1 * 1", "0 6 L * *", "0 6 * * 5L",
  "0 6 * * 1#2", "0 6 * *", "0 0 6 * * 1", "", "x 6 * * *", "60 6 * * *", "0 6 5-1 * *", "*-5 6 * * *", "*/0 6 * * *",
])("“%s” has no sentence", (expression) => {
  expect(calendarText(expression, "en")).toBeNull();
});

/** Whether a field of cron takes a number, read by itself: a range of one number with a step goes on to the end of the field. */
function takes(field: string, value: number, most: number): boolean {
  return field.split(",").some((part) => {
    const [span = "", by = "1"] = part.split("/");
    const [first = "", end = first] = span === "*" ? [String(most > 31 || most === 23 || most === 7 ? 0 : 1), String(most)] : span.split("-");
    const last = first === end && part.includes("/") ? most : Number(end);
    return value >= Number(first) && value <= last && (value - Number(first)) % Number(by) === 0;
  });
}

const SHAPES = {
  minute: ["0", "15", "*/5", "*/20", "*/30", "*/7", "*", "0,30", "5,20,35,50", "10-50/10", "3/10", "5-5/10"],
  hour: ["6", "*", "*/2", "*/5", "6-21", "8-18/2", "6,14,22", "0-5,22-23", "12-13", "6-6/2"],
  date: ["*", "1", "1,15", "10-12", "7-7/9"],
  month: ["*", "3", "1-6/2", "11-12", "3-3/2"],
  day: ["*", "1-5", "0", "7", "6,0", "*/2", "1-5/2", "2-7", "1-1/3"],
};

const numbers = (least: number, most: number): number[] => Array.from({ length: most - least + 1 }, (_, i) => least + i);
const taken = (field: string, least: number, most: number): number[] => (field === "*" ? [] : numbers(least, most).filter((each) => takes(field, each, most)));

test("what is told is what cron takes, of every shape", () => {
  const wrong: string[] = [];
  let told = 0;
  const check = (expression: string, one: unknown, other: unknown): void => {
    if (JSON.stringify(one) !== JSON.stringify(other)) wrong.push(expression);
  };
  for (const minute of SHAPES.minute) {
    for (const hour of SHAPES.hour) {
      const times = numbers(0, 1439).filter((at) => takes(hour, Math.floor(at / 60), 23) && takes(minute, at % 60, 59));
      for (const date of SHAPES.date) {
        for (const month of SHAPES.month) {
          for (const day of SHAPES.day) {
            const expression = [minute, hour, date, month, day].join(" ");
            const rhythm = rhythmOf(expression);
            if (rhythm === null) continue;
            told += 1;
            const { dates, days, every, months, timesMin } = rhythm;
            check(expression, every === null ? timesMin : numbers(every.firstMin, every.lastMin).filter((at) => (at - every.firstMin) % every.stepMin === 0), times);
            check(expression, days.length === 0 ? DAYS : days, DAYS.filter((name) => takes(day, Number(name), 7) || (name === "0" && takes(day, 7, 7))));
            check(expression, months, taken(month, 1, 12));
            check(expression, dates, taken(date, 1, 31));
          }
        }
      }
    }
  }
  expect(wrong).toEqual([]);
  expect(told).toBeGreaterThan(1_500);
});
