import { signal } from "@preact/signals";
import type { FunctionComponent } from "preact";
import { useEffect } from "preact/hooks";
import { bring } from "../../../api/bring";
import type { ScenarioView } from "../../../api/types";
import { world } from "../../../stream/stream";

/** Loaded when something is played. */
const steps = signal<FunctionComponent<{ scenario: ScenarioView }> | null>(null);

/** What the simulated factory plays. Nothing elsewhere. */
export function ScenarioCard() {
  const [scenario] = world.value?.scenarios.values() ?? [];
  const isPlayed = scenario !== undefined;
  useEffect(() => {
    if (!isPlayed || steps.value) return;
    return bring(async () => (await import("./ScenarioSteps")).load(), (loaded) => { steps.value = loaded; });
  }, [isPlayed]);
  const Steps = steps.value;
  return isPlayed && Steps ? <Steps scenario={scenario} /> : null;
}
