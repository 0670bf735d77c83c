import { describe, expect, test } from "vitest";
import { type Circumstances, hindranceOf, type VehicleKind } from "./hindrance";

const well: Circumstances = { connected: true, ended: false, lost: false };
const free = { status: "working", problem: "", acknowledged: false, help: null, out_of_service: null, sent_to_charge: false } as const;
const stopped = { ...free, status: "stopped" } as const;
const KINDS: readonly VehicleKind[] = ["stop", "acknowledge", "resume", "set_speed", "promise", "hand_over", "charge", "take_out", "put_in"];

describe("what keeps a command from being given", () => {
  test.each<[string, Partial<Circumstances>]>([
    ["offline", { connected: false }], ["ended", { ended: true }], ["lost", { lost: true }],
  ])("%s: all of them, but never a stop", (hindrance, more) => {
    const ready = { ...stopped, acknowledged: true, help: { until_at_s: 0, promised_by: "", promise_max_s: 900 } };
    expect(KINDS.map((kind) => hindranceOf(kind, ready, { ...well, ...more }))).toEqual([null, ...Array<string>(8).fill(hindrance)]);
  });

  test("who is not stopped is neither acknowledged nor resumed", () => {
    expect(hindranceOf("acknowledge", free, well)).toBe("not_stopped");
    expect(hindranceOf("resume", free, well)).toBe("not_stopped");
  });

  test("a fault that is still there cannot be acknowledged, and what is not acknowledged not resumed", () => {
    expect(hindranceOf("acknowledge", { ...stopped, problem: "the load has shifted" }, well)).toBe("faulty");
    expect(hindranceOf("resume", stopped, well)).toBe("not_acknowledged");
  });

  test("first one act, then the other, never both at once", () => {
    const acknowledged = { ...stopped, acknowledged: true };
    expect([stopped, acknowledged].map((atv) => hindranceOf("acknowledge", atv, well))).toEqual([null, "acknowledged"]);
    expect([stopped, acknowledged].map((atv) => hindranceOf("resume", atv, well))).toEqual(["not_acknowledged", null]);
  });

  test("who is sent to charge is sent once, and is put to work again", () => {
    const sent = { ...free, sent_to_charge: true };
    expect([free, sent].map((atv) => hindranceOf("charge", atv, well))).toEqual([null, "sent_to_charge"]);
    expect([free, sent].map((atv) => hindranceOf("put_in", atv, well))).toEqual(["in_service", null]);
  });

  test("nobody promises to come where nothing waits", () => {
    expect(hindranceOf("promise", free, well)).toBe("no_help_wanted");
    expect(hindranceOf("hand_over", free, well)).toBe("no_help_wanted");
    expect(hindranceOf("promise", { ...free, help: { until_at_s: 5, promised_by: "", promise_max_s: 900 } }, well)).toBeNull();
  });
});
