import { readFileSync } from "node:fs";
import { describe, expect, test } from "vitest";
import type { WhyView } from "../../../api/types";
import { whyText } from "./why-text";

const NO_REASON: WhyView = {
  kind: "waiting", agent: "", total_s: 0, bidders: 0, left: 0, other: "", by_s: 0, part: "", part_s: 0, tie_by: "",
  passed: [], refused: [], round: 1, radius_m: 25, replaced: "", reason: "", silent_s: 0, confirmed: true,
  coordinator: "M8", text: "",
};
const text = (more: Partial<WhyView>): string => whyText({ why: { ...NO_REASON, ...more } }).replaceAll("\u202f", " ");
const cheapest: Partial<WhyView> = {
  kind: "cheapest", agent: "ATV2", total_s: 54.8, bidders: 3, left: 3, other: "ATV1", by_s: 1.1, part: "empty_way",
};
const passed = (answer: string, takenFor = "") => ({ agent: "ATV3", less_s: 4.8, answer, taken_for: takenFor });

describe("the sentence says what the gateway found", () => {
  test("about the cheapest one, and who was cheaper but not to be had", () => {
    expect(text(cheapest)).toBe(
      "ATV2 was chosen because it was the cheapest of 3 that bid (54.8 s, 1.1 s less than ATV1). " +
        "Most of the difference comes from its shorter empty way.",
    );
    expect(text({ ...cheapest, left: 2, part: "", passed: [passed("busy", "M7")] })).toBe(
      "ATV2 was chosen because it was the cheapest of the 2 that were left (54.8 s, 1.1 s less than ATV1); " +
        "ATV3 was 4.8 s cheaper but had been taken by M7 in the meantime.",
    );
  });

  test("about the only one, with the refusals by reason", () => {
    const refused = [{ reason: "busy", agents: ["ATV1", "ATV4"], detail: "" }, { reason: "battery", agents: ["ATV6"], detail: "" }];
    expect(text({ kind: "only", agent: "ATV2", total_s: 54.8, bidders: 1, refused })).toBe(
      "ATV2 was chosen because nobody else bid (54.8 s). 3 refused: busy (2), with too little battery (1).",
    );
  });

  test("about those that take no work, each by what keeps it from that", () => {
    const reserve = "in the reserve: the floor has no room for more at work";
    const refused = [{ reason: "not_fit", agents: ["ATV1", "ATV4"], detail: reserve }, { reason: "not_fit", agents: ["ATV6"], detail: "out of service" }];
    expect(text({ refused })).toBe("Nobody has bid yet. 3 refused: in the reserve (2), taken out of service (1).");
    expect(text({ refused: refused.slice(0, 1) })).toBe("Nobody has bid yet. 2 refused for the same reason: in the reserve.");
    expect(text({ refused: refused.slice(1) })).toBe("Nobody has bid yet. ATV6 refused: taken out of service.");
  });

  test("also where the reason is a sentence of its own", () => {
    const detail = "the place where it stands is not its own yet";
    const refused = [{ reason: "not_fit", agents: ["ATV1", "ATV4"], detail }, { reason: "not_fit", agents: ["ATV6"], detail: "a load is on board" }];
    expect(text({ refused: refused.slice(0, 1) })).toBe(`Nobody has bid yet. 2 refused for the same reason: ${detail}.`);
    expect(text({ refused })).toBe(`Nobody has bid yet. 3 refused: ${detail} (2), a load is still on board (1).`);
  });

  test("about a takeover, and whether it is confirmed", () => {
    const why: Partial<WhyView> = { kind: "took_over", agent: "ATV1", replaced: "ATV3", reason: "silent", silent_s: 3.6 };
    const said = "ATV1 watched over it and took it over because nothing had been heard of ATV3 for 3.6 s.";
    expect(text(why)).toBe(said);
    expect(text({ ...why, confirmed: false })).toBe(`${said} M8 has not confirmed that yet.`);
  });

  test("about rounds, and who failed before", () => {
    expect(text({ round: 2, radius_m: 50, replaced: "ATV3", reason: "silent", silent_s: 4.2 })).toBe(
      "Nobody has bid yet. It was announced anew because ATV3 could not go on with it (silent for 4.2 s). " +
        "This is round 2, which asks within 50 m.",
    );
  });
});

test("there are words for everything that the gateway has words for", () => {
  const python = readFileSync(new URL("../../../../../backend/dray/gateway/live/projection/auctions/why_text.py", import.meta.url), "utf8");
  const words = (table: string): string[] => {
    const body = new RegExp(`^${table} = \\{\\n([^}]*)\\}`, "m").exec(python)?.[1] ?? "";
    return [...body.matchAll(/^ {4}"(\w+)": "(.*)",$/gm)].map((found) => `${found[1]}: ${found[2]}`);
  };
  expect(words("ANSWERS").length).toBeGreaterThan(8);
  for (const each of words("ANSWERS")) {
    const [answer = "", said = ""] = each.split(": ");
    expect(text({ kind: "only", passed: [passed(answer)] })).toContain(`but ${said}.`);
  }
  for (const each of words("REFUSALS")) {
    const [reason = "", said = ""] = each.split(": ");
    expect(text({ refused: [{ reason, agents: ["ATV1"], detail: "" }] })).toContain(`refused: ${said}.`);
  }
  for (const each of words("TIES")) {
    const [tie, said = ""] = each.split(": ");
    expect(text({ ...cheapest, kind: "tie", tie_by: tie as WhyView["tie_by"] })).toContain(said);
  }
  for (const each of words("PARTS")) {
    const [part = "", said = ""] = each.split(": ");
    expect(text({ ...cheapest, part })).toContain(`comes from ${said}.`);
  }
});
