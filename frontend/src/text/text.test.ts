import { describe, expect, test } from "vitest";
import { textsFrom } from "./catalogue";
import { en } from "./en";
import { formatsFor } from "./format";
import { chooseLocale } from "./index";

const format = formatsFor("en-GB", "UTC");
const de = formatsFor("de-DE", "UTC");
const texts = textsFrom(en, "en-GB");
/** Figures and units are kept together by a narrow space that does not break. */
const plain = (text: string): string => text.replaceAll("\u202f", " ");

describe("formats", () => {
  test.each([
    [0, "0 s"], [71.4, "71 s"], [119, "119 s"], [120, "2:00 min"], [220, "3:40 min"], [7199, "119:59 min"],
    [7500, "2:05 h"], [-30, "−30 s"],
  ])("a duration of %d s is %s", (seconds, text) => {
    expect(plain(format.duration(seconds))).toBe(text);
  });

  test.each([[0.44, "0.4 s"], [-1, "0.0 s"], [12.3, "12 s"], [180, "3:00 min"]])("an age of %d s is %s", (s, text) => {
    expect(plain(format.age(s))).toBe(text);
  });

  test("numbers follow the locale", () => {
    expect(plain(format.percent(0.974, 1))).toBe("97.4 %");
    expect(plain(de.percent(0.974, 1))).toBe("97,4 %");
    expect(de.count(12000)).toBe("12.000");
  });

  test("times are of a 24 hour clock", () => {
    expect(format.clock(Date.UTC(2026, 0, 1, 0, 5, 9) / 1000)).toBe("00:05:09");
  });

  test("a due time is as long as it must be", () => {
    const now = Date.UTC(2026, 4, 4, 8) / 1000;
    expect(format.due(now + 3600, now)).toBe("09:00");
    expect(format.due(now + 3 * 86400, now)).toMatch(/^Thu.*08:00$/);
    expect(format.due(now + 30 * 86400, now)).toMatch(/^3 Jun.*08:00$/);
  });
});

describe("texts", () => {
  test("are filled in, once per name", () => {
    expect(texts.t("machine.level", { level: 3, capacity: 9 })).toBe("3 / 9");
  });

  test("follow the number", () => {
    expect(texts.n("alerts.alarm", 1)).toBe("1 alarm");
    expect(texts.n("alerts.alarm", 2)).toBe("2 alarms");
  });

  test("leave a word of a newer server readable", () => {
    expect(texts.word("reason", "battery")).toBe("battery");
    expect(texts.word("reason", "too_heavy")).toBe("too heavy");
  });

  test("come in a language that we speak", () => {
    expect(chooseLocale(["fr-FR", "en-US"])).toBe("en-US");
    expect(chooseLocale(["fr-FR"])).toBe("en-GB");
  });

  test("have both forms wherever they count", () => {
    const keys = new Set<string>(Object.keys(en));
    for (const key of keys) if (key.endsWith(".other")) expect(keys).toContain(key.replace(/other$/, "one"));
  });
});
