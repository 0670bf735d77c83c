import { describe, expect, test, vi } from "vitest";
import type { ClosureView, NewsView } from "../../../api/types";
import type { World } from "../../../stream/world";
import { keyOf, lately, strips, subjectOf, toneOf } from "./news";
import { newsText } from "./news-text";
import { showNews } from "./show";

const news = (more: Partial<NewsView>): NewsView => ({
  id: "M8-3@2", kind: "took_over", at_s: 100, agent: "ATV1", other: "ATV3", task: "M8-3", epoch: 2, goal: "",
  successor: "", arrived: 0, order: "", reason: "silent", cause: null, silent_s: 3.6, until_at_s: null, confirmed: true, agents: [], closure: null, ...more,
});

describe("news in words", () => {
  const NOW_S = 1_900_000_000;
  const text = (each: NewsView): string => newsText(each, NOW_S, {
    goal: () => "24 Gear unit G2", order: () => "PO-17", closure: ({ area }) => ({ where: area, how: "closed" }),
  });

  test("say who took over from whom, and after how much silence", () => {
    expect(text(news({}))).toBe("ATV1 took over M8-3 from ATV3 after 3.6\u202fs of silence");
  });

  test("say that a takeover is under way until the machine has confirmed it", () => {
    expect(text(news({ confirmed: false }))).toContain("takes over");
  });

  test("name another reason than silence", () => {
    expect(text(news({ reason: "in_error" }))).toBe(
      "ATV1 took over M8-3 from ATV3: in error, and not helped in time",
    );
  });

  test("of a lost goal tell what was delivered, and that the rest goes on", () => {
    const lost = news({ kind: "goal_lost", agent: "M8", goal: "G1", successor: "G2", arrived: 4 });
    expect(text(lost)).toBe("M8 failed with 24 Gear unit G2: 4 delivered, the rest is announced anew");
    expect(text({ ...lost, successor: "" })).toContain("all delivered");
  });

  test("name the order that waits by its customer's reference", () => {
    const machines = [{ agent: "M8", reason: "silent" }];
    const cause = { reason: "", detail: "", machines, lacks: [], not_made: [], handover: null, wait: null, clock_ahead_s: 0, times: 1, text: "" };
    const waits = news({ kind: "goal_waits", order: "O-1", cause });
    expect(text(waits)).toBe("Order PO-17 waits: M8 is silent");
  });

  const closure = { area: "North", reason: "oil" } as ClosureView;

  test("tell silence with its length, and of whom people have stopped, carried away and closed", () => {
    expect(text(news({ kind: "silent", agents: ["ATV1", "ATV2"] }))).toBe("Nothing is heard of ATV1, ATV2 any more");
    expect(text(news({ kind: "heard_again", silent_s: 123 }))).toBe("ATV1 heard again after 2:03\u202fmin of silence");
    expect(text(news({ kind: "stopped", other: "Mara" }))).toBe("Mara stopped ATV1");
    expect(text(news({ kind: "carried_away", other: "Mara" }))).toBe("Mara has carried ATV1 away");
    expect(text(news({ kind: "closed", other: "Mara", closure }))).toBe("Mara: North closed. oil");
    expect(text(news({ kind: "opened", closure }))).toBe("North is open again");
  });

  test.each([
    "took_over", "takeover_refused", "announced_anew", "link_lost", "link_back", "help_asked", "help_promised",
    "goal_lost", "goal_waits", "memory_lost", "silent", "heard_again", "carried_away", "put_back", "stopped", "closed", "opened",
  ] as const)("leave no gap in %s", (kind) => {
    const said = text(news({ kind, goal: "G1", until_at_s: NOW_S, closure }));
    expect(said).not.toMatch(/[{}]/);
    expect(said.length).toBeGreaterThan(10);
  });
});

describe("strips over the map", () => {
  test("show what is new, the newest first, and no more than three", () => {
    const all = [1, 2, 3, 4].map((n) => news({ id: `${n}`, at_s: 100 + n }));
    expect(strips(all, 105, new Set()).map(({ id }) => id)).toEqual(["4", "3", "2"]);
  });

  test("leave out what is old, quiet or dismissed", () => {
    const old = news({ id: "old", at_s: 80 });
    const quiet = news({ id: "quiet", kind: "link_back" });
    const seen = news({ id: "seen" });
    expect(strips([old, quiet, seen], 105, new Set([keyOf(seen)]))).toEqual([]);
  });

  test("come again when the same is told anew", () => {
    const first = news({ id: "link-ATV2", kind: "link_lost" });
    const again = { ...first, at_s: 104 };
    expect(strips([again], 105, new Set([keyOf(first)]))).toEqual([again]);
  });
});

test("the list is newest first, whatever the order in which it came", () => {
  expect(lately([news({ id: "a", at_s: 1 }), news({ id: "b", at_s: 3 }), news({ id: "c", at_s: 2 })]).map(({ id }) => id)).toEqual(["b", "c", "a"]);
});

test("news lead to the task, else to whom they are about, else nowhere", () => {
  const world = { tasks: new Map([["M8-3", {}]]), atvs: new Map([["ATV1", {}]]), machines: new Map([["M8", {}]]) } as unknown as World;
  expect(subjectOf(news({}), world)).toEqual({ kind: "task", id: "M8-3" });
  expect(subjectOf(news({ task: "" }), world)).toEqual({ kind: "atv", id: "ATV1" });
  expect(subjectOf(news({ task: "", agent: "M8" }), world)).toEqual({ kind: "machine", id: "M8" });
  expect(subjectOf(news({ task: "", agent: "strategist" }), world)).toBeNull();
});

test("news of an order that waits lead to its page", () => {
  const address = { hash: "" };
  vi.stubGlobal("location", address);
  showNews(news({ kind: "goal_waits", agent: "strategist", task: "", order: "O-1" }));
  expect(address.hash).toBe("#orders/O-1");
  vi.unstubAllGlobals();
});

test("what waits for a person warns; what the plant has mended itself does not", () => {
  expect(toneOf(news({ kind: "help_asked" }))).toBe("warn");
  expect(toneOf(news({}))).toBe("chosen");
  expect(toneOf(news({ kind: "link_back" }))).toBe("normal");
});
