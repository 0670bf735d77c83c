import { describe, expect, test } from "vitest";
import type { FaultView } from "../../../api/types";
import { faultOf, faultsOf, isOn, onLane } from "./faults";

const fault = (id: string, began_at_s: number, agents: string[]) =>
  ({ id, began_at_s, agents, kind: "wlan_cut", fault: {} }) satisfies FaultView;

describe("a fault by hand", () => {
  test("says whom it is about in the words of its kind", () => {
    expect(faultOf("wlan_cut", "ATV3", "by hand")).toEqual({ kind: "wlan_cut", agent: "ATV3" });
    expect(faultOf("vehicle_broken", "ATV3", "by hand")).toEqual({ kind: "vehicle_broken", atv: "ATV3", reason: "by hand" });
    expect(faultOf("machine_broken", "M8", "by hand")).toEqual({ kind: "machine_broken", machine: "M8", reason: "by hand" });
    expect(faultOf("load_shifted", "ATV3", "by hand")).toEqual({ kind: "load_shifted", atv: "ATV3" });
  });

  test("is found at its agent, the oldest first", () => {
    const all = [fault("2", 5, ["ATV3"]), fault("1", 3, ["ATV3", "ATV4"]), fault("3", 1, [])];
    expect(faultsOf(all, "ATV3").map(({ id }) => id)).toEqual(["1", "2"]);
    expect(faultsOf(all, "ATV9")).toEqual([]);
  });

  test("is not offered twice", () => {
    expect(isOn([fault("1", 1, ["ATV3"])], "wlan_cut")).toBe(true);
    expect(isOn([fault("1", 1, ["ATV3"])], "powered_off")).toBe(false);
  });
});

test("what is in the way on a lane is found from both of its ends", () => {
  const fault = { id: "F1", kind: "lane_blocked", fault: { start: "c3", end: "m5-lane", thing: "door" }, agents: [], began_at_s: 1 };
  expect(onLane([fault], { start: "m5-lane", end: "c3" })).toEqual([fault]);
  expect(onLane([fault], { start: "c3", end: "m5-lane" })).toEqual([fault]);
  expect(onLane([fault], { start: "c3", end: "c4" })).toEqual([]);
});
