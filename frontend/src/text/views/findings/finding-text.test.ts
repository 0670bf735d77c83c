import { expect, test } from "vitest";
import { speak } from "../../speech";
import { findings as de } from "./de";
import { findingText } from "./finding-text";

const near = {
  code: "near",
  text: "English",
  values: {
    pairs: [{ code: "pair_room", text: "English", values: { one: "N1", other: "N2", away_m: 0.5, needed_m: 1.234 } }, "N3"],
    length_m: 1.2,
    width_m: 1,
  },
};

test("a finding is told in the reader's language, with what stands in it", () => {
  speak("de", de, "de-DE");
  expect(findingText(near)).toContain("N1 und N2 (0,50 m, nötig 1,23 m), N3 liegen näher beieinander, als Fahrzeuge von 1,20 m × 1 m");
});

test("of a code that this panel does not know the gateway's English is told", () => {
  speak("de", de, "de-DE");
  expect(findingText({ code: "newer", values: {}, text: "English" })).toBe("English");
  expect(findingText({ text: "no code" })).toBe("no code");
});
