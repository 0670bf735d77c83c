import { describe, expect, test } from "vitest";
import type { PlantFile, WaitCauseView } from "../api/types";
import { de } from "./manager/de";
import { en } from "./manager/en";
import { es } from "./manager/es";
import { speak } from "./speech";
import { callPlacesAs } from "./place";
import { jamText, waitText } from "./wait";

const cause = (more: Partial<WaitCauseView>): WaitCauseView => ({ kind: "docked", chain: ["ATV3", "ATV7"], more: 0, place: "M8", since_at_s: null, ...more });

describe("a wait", () => {
  test("is a sentence down to what holds all of them up", () => {
    expect(waitText(cause({}))).toBe("waits for ATV3, which waits for ATV7 at the dock of M8");
    callPlacesAs({ warehouses: [{ id: "DELIVERY", name: "Delivery" }] as PlantFile["warehouses"] });
    expect(waitText(cause({ chain: ["ATV7"], place: "DELIVERY" }))).toBe("waits for ATV7 at the dock of Delivery");
    expect(waitText(cause({ chain: ["ATV7"], place: "" }))).toBe("waits for ATV7 at a dock");
    expect(waitText(cause({ chain: ["ATV7"], place: "CH2", kind: "charging" }))).toBe("waits for ATV7, which is charging at CH2");
    expect(waitText(cause({ chain: ["ATV7"], place: "", kind: "standing" }))).toBe("waits for ATV7, which stands there");
    expect(waitText(cause({ chain: ["ATV7"], kind: "silent" }))).toBe("waits for ATV7, which is not heard");
    expect(waitText(cause({ chain: ["ATV2", "ATV1"], kind: "circle" }))).toBe("waits for ATV2, which waits for ATV1, in a circle");
  });

  test("of a long chain says how many are left out", () => {
    expect(waitText(cause({ more: 4 }))).toBe("waits for ATV3, which waits for 4 more, which waits for ATV7 at the dock of M8");
  });

  test("for nobody says why", () => {
    expect(waitText(cause({ chain: [], kind: "closed" }))).toBe("has no way left: lanes are closed");
    expect(waitText(cause({ chain: [], kind: "unanswered" }))).toBe("makes room, or has no answer yet");
  });

  test("for a vehicle that its reader may not see does not name it", () => {
    expect(waitText(cause({ chain: ["*"], kind: "moving" }))).toBe("waits for a vehicle elsewhere, which is driving");
  });

  test("has words for every cause in every language", () => {
    for (const [language, table] of Object.entries({ en, de, es })) {
      speak(language as "en", table, language);
      for (const kind of ["docked", "charging", "silent", "stopped", "error", "closed", "circle", "standing", "moving", "unanswered"] as const) {
        expect(waitText(cause({ kind }))).toContain("ATV7");
      }
      expect(waitText(cause({}))).toContain("M8");
    }
    speak("en", en, "en-GB");
  });
});

describe("a jam", () => {
  test("names all that wait, and for whom in the end", () => {
    expect(jamText(["ATV5", "ATV3"], cause({ chain: ["ATV7"] }))).toBe("2 vehicles (ATV5, ATV3) wait for ATV7 at the dock of M8");
  });

  test("in a circle says who waits for whom", () => {
    expect(jamText(["ATV1", "ATV2"], cause({ kind: "circle", chain: ["ATV1", "ATV2"] }))).toBe("2 vehicles (ATV1, ATV2) wait for one another: ATV1 → ATV2 → ATV1");
  });
});
