import { expect, test } from "vitest";
import type { TaskView } from "../../api/types";
import { strandedOf } from "./stranded";

function task(id: string, untilS: number | null): TaskView {
  const stranded = untilS === null ? null : { atv: "ATV1", node: "c2", until_at_s: untilS, handed_at: "" };
  return { id, stranded } as unknown as TaskView;
}

test("of goods that wait for a word those come first that are given up first, and nothing that goes on", () => {
  const all = [task("M7-1", 200), task("M7-2", null), task("M8-1", 100), task("M6-9", 200)];
  expect(strandedOf(all).map(({ id }) => id)).toEqual(["M8-1", "M6-9", "M7-1"]);
});
