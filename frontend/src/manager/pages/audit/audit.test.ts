import { describe, expect, test } from "vitest";
import { detailText, NOTHING, queryOf, tableOf } from "./filter";

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

test("what else a line tells is one line of text", () => {
  expect(detailText({ kind: "set_speed", speed_frac: 0.5 })).toBe("kind set_speed · speed_frac 0.5");
  expect(detailText({ agents: ["ATV2", "M5"] })).toBe("agents ATV2, M5");
  expect(detailText({})).toBe("");
});
