import { describe, expect, test } from "vitest";
import { records as de } from "../../../text/views/records/de";
import { records as en } from "../../../text/views/records/en";
import { faults } from "../../../text/views/faults/de";
import { speak } from "../../../text/speech";
import { detailText } from "./detail";
import { NOTHING, queryOf, tableOf } from "./filter";

describe("the filter of the audit log", () => {
  test("asks for everything while it is empty", () => {
    expect(queryOf(NOTHING)).toEqual({});
    expect(tableOf(NOTHING)).toBe("/api/audit?format=csv");
  });

  test("asks in seconds since 1970, and for what was filled in", () => {
    const since = "2030-06-01T14:00";
    const filter = { ...NOTHING, since, who: " manager ", result: "refused" };
    const sinceS = new Date(since).getTime() / 1000;
    expect(queryOf(filter)).toEqual({ since: sinceS, who: "manager", result: "refused" });
    expect(tableOf(filter)).toBe(`/api/audit?since=${sinceS}&who=manager&result=refused&format=csv`);
  });
});

test("what else a line tells is one line of text in people's words", () => {
  const plain = (text: string): string => text.replaceAll("\u202f", " ");
  speak("en", en, "en-GB");
  expect(plain(detailText({ kind: "set_speed", speed_frac: 0.5 }))).toBe("kind set speed · speed 50 %");
  expect(detailText({ agents: ["ATV2", "M5"] })).toBe("agents ATV2, M5");
  expect(detailText({ kind: "one_way", lane: { start: "a1", end: "a2" }, after_work: true })).toBe("kind one-way · lane (from a1 · to a2) · after its work");
  expect(detailText({ change: '{"priority":"urgent","due_at":null}' })).toBe("change (priority urgent · due none)");
  expect(detailText({ name: "ERP", days: null, place: "", areas: [] })).toBe("name ERP");
  expect(detailText({})).toBe("");
  // Without a vehicle there is none that alone may do it.
  expect(detailText({ to: "M8", vehicle_only: true })).toBe("to M8");
  expect(detailText({ vehicle: "ATV2", vehicle_only: true })).toBe("vehicle ATV2 · only this vehicle");
  expect(detailText({ time_zone: "Europe/Berlin", missed: "skip" })).toBe("time zone Europe/Berlin · missed runs left out");
  expect(detailText({ kind: "resume", after_work: false, command: "6c21f0a4-0b7e-4c55-9a40-1f2d3c4b5a69" })).toBe("kind resume");
  speak("de", de, "de-DE");
  expect(plain(detailText({ kind: "take_out", reason: "kind", wait_s: 3600 }))).toBe("Art aus dem Betrieb nehmen · Grund kind · für 60:00 min");
  speak("de", { ...de, ...faults }, "de-DE");
  expect(detailText({ kind: "machine_broken", agents: ["M6"] })).toBe(`Art ${faults["fault.now.machine_broken"]} · Agenten M6`);
});
