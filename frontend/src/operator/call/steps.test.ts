import { expect, test } from "vitest";
import type { TransportAnswer } from "../../api/transports";
import { abilitiesOf, canCallOff, loadFrom, loadOf, shownCalls, stepOf, unwillingOf } from "./steps";

const call = (more: Partial<TransportAnswer> = {}): TransportAnswer => ({
  id: "T1", status: "waiting", from: "S3", to: "M8", item: "shaft", thing: null, quantity: 40, priority: "normal", vehicle: null, vehicle_until: null, vehicle_waits: null, shortage: null, ability: null, called_by: "anna",
  created_at: "2030-01-01T10:00:00Z", due_at: "2030-01-01T10:15:00Z", not_before: null, cancel_at: null, ended_at: null, updated_at: "2030-01-01T10:00:00Z",
  carrier: null, expected_at: null, task: null, wait: null, refused: null, ...more,
});

test.each([["waiting", 0], ["assigned", 1], ["on_board", 2], ["delivered", 3], ["cancelled", null]])("%s is step %s", (status, step) => {
  expect(stepOf(call({ status }))).toBe(step);
});

test("what most types of vehicles carry is offered first", () => {
  expect(abilitiesOf([{ abilities: ["pallet", "tote"] }, { abilities: ["tote"] }])).toEqual(["tote", "pallet"]);
  expect(abilitiesOf([])).toEqual([]);
});

test("it is called off until it is on board, and once", () => {
  expect(canCallOff(call())).toBe(true);
  expect(canCallOff(call({ status: "on_board" }))).toBe(false);
  expect(canCallOff(call({ cancel_at: "2030-01-01T10:01:00Z" }))).toBe(false);
});

test("what has ended leaves after ten minutes", () => {
  const ended = call({ status: "delivered", ended_at: "2030-01-01T10:05:00Z" });
  expect(shownCalls([ended], Date.parse("2030-01-01T10:14:00Z"))).toHaveLength(1);
  expect(shownCalls([ended], Date.parse("2030-01-01T10:16:00Z"))).toHaveLength(0);
});

test("each load of a choice is sent under a key of its own, and again under the same", () => {
  const choice = { item: "shaft", way: "take", key: "k" } as const;
  expect(loadOf(choice, "M8", 40, false, 1).draft).toEqual({ from: "M8", item: "shaft", quantity: 40, priority: "normal" });
  expect(loadOf(choice, "M8", 40, false, 1).key).toBe(loadOf(choice, "M8", 40, false, 1).key);
  expect(loadOf(choice, "M8", 40, false, 2).key).not.toBe(loadOf(choice, "M8", 40, false, 1).key);
});

test("no more is taken away than is there, nor than one load", () => {
  const buffers = [{ item: "shaft", level: 33 }, { item: "bearing", level: 90 }];
  expect(loadFrom(buffers, "shaft", 40)).toBe(33);
  expect(loadFrom(buffers, "bearing", 40)).toBe(40);
});

test("of each vehicle its newest reason is told, and what holds for most first", () => {
  const said = (agent: string, reason: string, role: "primary" | "secondary" = "primary") => ({ agent, reason, role, epoch: 1, round: 1, detail: "" });
  const refusals = [said("ATV1", "busy"), said("ATV3", "charging"), said("ATV2", "battery"), said("ATV1", "battery"), said("ATV9", "busy", "secondary")];
  expect(unwillingOf({ refusals })).toEqual([{ reason: "battery", vehicles: ["ATV1", "ATV2"] }, { reason: "charging", vehicles: ["ATV3"] }]);
  expect(unwillingOf(undefined)).toEqual([]);
});
