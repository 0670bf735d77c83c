import { expect, test } from "vitest";
import type { TaskView } from "../../api/types";
import { heldOf } from "./held";

function task(id: string, openedS: number, reason: string | null): TaskView {
  return { id, opened_at_s: openedS, trouble: reason === null ? null : { reason } } as unknown as TaskView;
}

test("somebody has to look for loads that were disputed and at docks that fail, the oldest first, and for no others", () => {
  const all = [
    task("M7-1", 200, "disputed"),
    task("M7-2", 50, "silent"),
    task("S1-1", 100, "disputed"),
    task("M6-9", 10, null),
    task("M5-3", 150, "dock_fails"),
  ];
  expect(heldOf(all).map(({ id }) => id)).toEqual(["S1-1", "M5-3", "M7-1"]);
});
