import { describe, expect, test } from "vitest";
import { detailText, NOTHING, queryOf } from "./filter";

describe("the filter of the audit log", () => {
  test("asks for everything while it is empty", () => {
    expect(queryOf(NOTHING)).toBe("");
    expect(queryOf(NOTHING, { limit: "50", cursor: "" })).toBe("limit=50");
  });

  test("asks in seconds since 1970, and for what was filled in", () => {
    const since = "2030-06-01T14:00";
    const query = new URLSearchParams(queryOf({ ...NOTHING, since, who: " manager ", result: "refused" }));
    expect(Object.fromEntries(query)).toEqual({
      since: String(new Date(since).getTime() / 1000), who: "manager", result: "refused",
    });
  });
});

test("what else a line tells is one line of text", () => {
  expect(detailText({ kind: "set_speed", speed_frac: 0.5 })).toBe("kind set_speed · speed_frac 0.5");
  expect(detailText({ agents: ["ATV2", "M5"] })).toBe("agents ATV2, M5");
  expect(detailText({})).toBe("");
});
