import { expect, test } from "vitest";
import type { ScenarioView, StepView } from "../../../api/types";
import { leftS, nextOf } from "./steps";

const step = (name: StepView["step"], more: Partial<StepView> = {}): StepView => ({ step: name, after_s: null, expected_s: null, agents: [], ...more });
const scenario = (steps: StepView[], state: ScenarioView["state"] = "playing"): ScenarioView => ({
  id: "case-5", shows: "", steps, state, after_s: null, checks: [], began_at_s: 1000, skipping: false,
});

test("the next step is the first that has not happened, as long as nothing is known of when they come", () => {
  const steps = [step("ordered", { after_s: 0 }), step("contracted"), step("delivered")];
  expect(nextOf(scenario(steps))?.step).toBe("contracted");
});

test("the next step is the one that is expected first", () => {
  const steps = [step("ordered", { after_s: 0 }), step("delivered", { expected_s: 700 }), step("brought_back", { expected_s: 690 }), step("bids_again")];
  expect(nextOf(scenario(steps))?.step).toBe("brought_back");
});

test("no step is next when all is over", () => {
  expect(nextOf(scenario([step("ordered")], "failed"))).toBeUndefined();
  expect(nextOf(scenario([step("ordered", { after_s: 0 })]))).toBeUndefined();
});

test("a countdown is of the factory's clock", () => {
  const next = step("contracted", { expected_s: 600 });
  expect(leftS(next, scenario([next]), 1020, 5)).toBe(500);
  expect(leftS(next, scenario([next]), 1130, 5)).toBe(-50);
  expect(leftS(step("contracted"), scenario([]), 1020, 5)).toBeNull();
});
