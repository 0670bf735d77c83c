import { describe, expect, test } from "vitest";
import type { MachineView } from "../../api/types";
import { machineNeedOf, needingMachines, waitingGoals } from "./need";

const NOW = { nowS: 100, speed: 1 };
const OUT = { by: "Maria", since_at_s: 50, reason: "bearings", back_at_s: null, after_work: false };
const goal = { goal: "1", product: "pump", quantity: 10, made: 4, to_begin: 6, delivered: 0, deadline_at_s: 900, offered: false, order_due_at_s: null, order_name: "" };

function machine(fields: Partial<MachineView> = {}): MachineView {
  const silence = { overdue_after_s: 10, lost_after_s: 30 };
  const usual = { id: "M1", problem: "", resettable: false, help: null, out_of_service: null, goals: [], shut_out: null };
  return { ...usual, seen_at_s: 99, silence, ...fields } as unknown as MachineView;
}

describe("a machine", () => {
  const waiting = { until_at_s: 200, promised_by: "", promise_max_s: 900 };
  test.each([
    [{}, "well"],
    [{ problem: "stuck", help: waiting }, "help"],
    [{ problem: "stuck", help: { ...waiting, promised_by: "Maria" } }, "coming"],
    [{ problem: "stuck", help: waiting, resettable: true }, "reset"],
    [{ seen_at_s: 10 }, "lost"],
    [{ out_of_service: OUT }, "out"],
    [{ out_of_service: OUT, seen_at_s: 10 }, "out"],
    [{ out_of_service: OUT, problem: "stuck", help: waiting }, "help"],
  ])("of %j is %s", (fields, need) => {
    expect(machineNeedOf(machine(fields), NOW)).toBe(need);
  });

  test("that has waited longest stands first, and one that is well has no card", () => {
    const all = [
      machine({ id: "M1", problem: "stuck", since_at_s: 80 }),
      machine({ id: "M2" }),
      machine({ id: "M3", out_of_service: OUT }),
    ];
    expect(needingMachines(all, NOW).map(({ id }) => id)).toEqual(["M3", "M1"]);
  });

  test("tells which goals wait for it, and the first deadline of them", () => {
    const done = { ...goal, made: 10, deadline_at_s: 1 };
    const sooner = { ...goal, deadline_at_s: 700 };
    expect(waitingGoals({ goals: [goal, sooner, done] })).toEqual({ goals: [goal, sooner], firstAtS: 700 });
    expect(waitingGoals({ goals: [] })).toEqual({ goals: [], firstAtS: null });
  });
});
