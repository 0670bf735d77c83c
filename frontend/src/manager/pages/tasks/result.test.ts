import { expect, test } from "vitest";
import { lateOf } from "./Result";

test("a promise is overdue while the task is not done, and kept or broken once it is", () => {
  const task = { closed_at_s: null, held: "", held_by: "", held_s: 0, kind: "production", promised_at_s: 100, state: "contracted" } as const;
  expect(lateOf(task, 130, 2)).toBe(60);
  expect(lateOf(task, 90, 2)).toBe(-20);
  expect(lateOf({ ...task, state: "delivered", closed_at_s: 95 }, 130, 2)).toBe(-10);
  expect(lateOf({ ...task, state: "withdrawn", closed_at_s: 130 }, 130, 2)).toBeNull();
  expect(lateOf({ ...task, promised_at_s: null }, 130, 2)).toBeNull();
});
