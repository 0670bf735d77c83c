import { expect, test } from "vitest";
import type { MachineView } from "../../api/types";
import { lookAlike, machineLooks } from "./machine-looks";

const stock = { item: "shaft", level: 10, capacity: 60, reorder_point: 20, on_order: 0, spare: 0 };
const machine = (more: Partial<MachineView> = {}): MachineView => ({
  id: "M1", name: "Press", status: "producing", product: "g1", goals: [], tasks: [], buffers: [stock], goods: [stock], documents: [],
  problem: "", about_problem: null, resettable: false, help: null, out_of_service: null, speed_frac: 1, since_at_s: null, waits: null, software: "", draining: false, unconfirmed: null, doubts: [], shut_out: null, probation: null, clock: null, seen_at_s: 100, silence: { beat_s: 5, overdue_after_s: 5.5, lost_after_s: 15.5 }, ...more,
});
const looks = (view: MachineView | undefined, lost = false) =>
  machineLooks(["M1"], new Map(view ? [["M1", view]] : []), () => lost);

test("a machine that only beats needs no new picture", () => {
  expect(lookAlike(looks(machine()), looks(machine({ seen_at_s: 101, goals: [] })))).toBe(true);
  expect(lookAlike(looks(undefined), looks(undefined))).toBe(true);
});

test.each<[string, Partial<MachineView>]>([
  ["status", { status: "starved" }],
  ["product", { product: "g2" }],
  ["stock", { buffers: [{ ...stock, level: 9 }] }],
  ["orders of material", { buffers: [{ ...stock, on_order: 40 }] }],
  ["finished goods", { goods: [] }],
])("a machine whose %s has changed needs one", (_what, more) => {
  expect(lookAlike(looks(machine()), looks(machine(more)))).toBe(false);
});

test("so does one that falls silent, or is heard for the first time", () => {
  expect(lookAlike(looks(machine()), looks(machine(), true))).toBe(false);
  expect(lookAlike(looks(undefined), looks(machine()))).toBe(false);
});
