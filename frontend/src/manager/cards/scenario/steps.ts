/** What the steps of a scenario say of themselves. */
import type { ScenarioView, StepView } from "../../../api/types";

/** The step that comes next: of those that have not happened the one that is expected first, or the first one where none is. */
export function nextOf({ state, steps }: ScenarioView): StepView | undefined {
  if (state !== "playing") return undefined;
  const open = steps.filter((step) => step.after_s === null);
  const expected = open.filter((step) => step.expected_s !== null);
  return expected.sort((one, other) => (one.expected_s ?? 0) - (other.expected_s ?? 0))[0] ?? open[0];
}

/**
 * Factory seconds until a step, as a rehearsal had it; below 0 when it is late, null where nothing is known.
 * @param nowS the plant's present on the wall clock
 * @param speed factory seconds per real second
 */
export function leftS(step: StepView, scenario: ScenarioView, nowS: number, speed: number): number | null {
  return step.expected_s === null ? null : step.expected_s - (nowS - scenario.began_at_s) * speed;
}
