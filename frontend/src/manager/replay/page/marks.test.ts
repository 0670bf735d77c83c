import { expect, test } from "vitest";
import type { Mark } from "./film";
import { leadText, markText } from "./marks";

const mark = (more: Partial<Mark>): Mark => ({ at_s: 100, kind: "late", about: "order_late", agent: "", other: "", task: "", order: "", ...more });

test("a mark's order stands last, so that it can be a link", () => {
  for (const one of [mark({ order: "O-1" }), mark({ order: "O-1", agent: "M8" }), mark({ agent: "ATV1", other: "ATV3" }), mark({})]) {
    expect(markText(one)).toBe(leadText(one) + one.order);
  }
  expect(markText(mark({ order: "O-1" }))).toMatch(/^[\d:]+ [^:]+: O-1$/);
  expect(markText(mark({ order: "O-1", agent: "M8" }))).toMatch(/: M8, O-1$/);
  expect(leadText(mark({}))).not.toMatch(/: $/);
});
