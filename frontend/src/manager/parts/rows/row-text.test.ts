import { afterEach, expect, test } from "vitest";
import { speak } from "../../../text/speech";
import { rows as de } from "../../../text/views/rows/de";
import { rows as en } from "../../../text/views/rows/en";
import { rowText } from "./row-text";

const fault = (code: string, column: string, values: Record<string, string> = {}) => ({ row: 3, column, code, values, reason: "in English" });

afterEach(() => { speak("en", en, "en-GB"); });

test("a fault is told in the reader's language, with what is filled in", () => {
  speak("de", de, "de-DE");
  expect(rowText(fault("not_made", "product", { product: "P9", products: "P1, P2" }))).toBe("Dieses Werk fertigt „P9“ nicht. Es fertigt: P1, P2.");
  expect(rowText(fault("at_least", "quantity", { least: "1" }))).toBe("Das ist zu klein. Mindestens 1.");
});

test("characters that may not stand there are told by what the column holds", () => {
  speak("en", en, "en-GB");
  expect(rowText(fault("pattern", "material"))).toContain("a letter first");
  expect(rowText(fault("pattern", "sha256"))).toContain("SHA-256");
  expect(rowText(fault("pattern", "customer"))).toBe("Here are characters that may not stand here.");
});

test("what has no words here is what the gateway says", () => {
  speak("en", en, "en-GB");
  expect(rowText(fault("of_a_newer_gateway", "x"))).toBe("It does not fit into this plant: in English");
  expect(rowText(fault("", "x"))).toBe("It does not fit into this plant: in English");
});
