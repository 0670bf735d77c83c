import { expect, test } from "vitest";
import type { AtvView } from "../../api/types";
import type { Command } from "../commands/life";
import { tileStateOf } from "./tile";

const NOW = { nowS: 1000, speed: 1 };
const atv = { id: "ATV1", status: "idle", problem: "", help: null, task: null, seen_at_s: 999, shut_out: null, silence: { beat_s: 5, overdue_after_s: 5.5, lost_after_s: 15.5 } } as unknown as AtvView;
const stop = (stage: Command["stage"]) => ({ stage }) as Command;

test.each<[string, AtvView | undefined, Command | undefined, string]>([
  ["is well", atv, undefined, "resting"],
  ["has left", undefined, undefined, "away"],
  ["has left and was told to stop", undefined, stop("not_confirmed"), "not_confirmed"],
  ["is silent", { ...atv, seen_at_s: 0 }, undefined, "lost"],
  ["is silent and the Stop never left", { ...atv, seen_at_s: 0 }, stop("not_sent"), "not_sent"],
  ["is stopped while its task waits", { ...atv, status: "stopped", help: { until_at_s: 1100, promised_by: "", promise_max_s: 900 } }, undefined, "stopped"],
])("below the Stop of one that %s stands what matters most", (_, seen, open, state) => {
  expect(tileStateOf(seen, open, NOW)).toBe(state);
});
