import { describe, expect, test } from "vitest";
import type { GoalView, MachineView } from "../api/types";
import { lastsS } from "./stock";

const spec = { makes: [{ product: "pump", cycle_s: 50, cycle_cv: 0, scrap_frac: 0 }, { product: "gear", cycle_s: 10, cycle_cv: 0, scrap_frac: 0 }] };
const products = [
  { id: "pump", bill: [{ material: "housing", quantity: 2 }] },
  { id: "gear", bill: [{ material: "shaft", quantity: 1 }] },
];
const goal = (product: string, quantity: number, made = 0, toBegin = quantity - made): GoalView =>
  ({ goal: `${product}-1`, product, quantity, made, to_begin: toBegin, delivered: 0, offered: false }) as GoalView;
const machine = (level: number, goals: GoalView[], more: Partial<MachineView> = {}) => ({
  goals, speed_frac: 1, status: "producing" as const, buffers: [{ item: "housing", level, capacity: 100, reorder_point: 0, on_order: 0, spare: 0 }], ...more,
});

describe("a material lasts", () => {
  test.each([
    ["until a piece lacks some", machine(5, [goal("pump", 10)]), 100],
    ["no time when there is none", machine(0, [goal("pump", 10)]), 0],
    ["through goals that take none of it", machine(5, [goal("gear", 6), goal("pump", 10)]), 160],
    ["as what is made already is left out", machine(5, [goal("pump", 10, 8)]), null],
    ["for the last piece, which is in the making", machine(0, [goal("pump", 10, 9, 0)]), null],
    ["as long as the pieces after the one in the making", machine(5, [goal("pump", 10, 0, 9)]), 100],
    ["without the goals that others may take", machine(5, [{ ...goal("pump", 10), offered: true }]), null],
    ["longer at a part of the speed", machine(5, [goal("pump", 10)], { speed_frac: 0.5 }), 200],
    ["through all goals where there is enough", machine(40, [goal("pump", 10), goal("pump", 10)]), null],
    ["until the goal for which it is not enough", machine(25, [goal("pump", 10), goal("pump", 10)]), 600],
    ["an unknown time at a machine that stands", machine(5, [goal("pump", 10)], { status: "error" }), null],
    ["an unknown time for a product that is not known", machine(5, [goal("valve", 1)]), null],
  ])("%s", (_name, at, expected) => {
    expect(lastsS(at, spec, products, "housing")).toBe(expected);
  });

  test("no time where there is no buffer of it", () => {
    expect(lastsS(machine(5, [goal("gear", 1)]), spec, products, "shaft")).toBe(0);
  });
});
