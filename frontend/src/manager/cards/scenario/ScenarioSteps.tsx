import type { ScenarioView, StepView } from "../../../api/types";
import { Card } from "../../../parts/Card";
import { choose } from "../../../selection/selection";
import { world } from "../../../stream/stream";
import { speakAlso } from "../../../text/speech";
import { factoryTime, inFactoryTime } from "../../../text/plant-time";
import { format, t, tables } from "../../../text/views/scenario";

/** The card, once it has its words. */
export async function load(): Promise<typeof ScenarioSteps> {
  await speakAlso(tables);
  return ScenarioSteps;
}

/** Which steps have happened and when, which one is next, how it ended. */
export function ScenarioSteps({ scenario }: { scenario: ScenarioView }) {
  const { after_s: afterS, checks, id, state, steps } = scenario;
  const next = state === "playing" ? steps.find((step) => step.after_s === null) : undefined;
  return (
    <Card class="scenario" title={inFactoryTime(t("scenario.title", { name: id }))}>
      <ol>
        {steps.map((step) => (
          <Line key={step.step} step={step} isNext={step === next} isOver={state !== "playing"} />
        ))}
      </ol>
      <p role="status" class={state === "failed" ? "tone-alarm" : ""}>
        {state !== "playing" && t(`scenario.${state}`, { after: factoryTime(afterS ?? 0) })}
      </p>
      {checks.length > 0 && (
        <details>
          <summary>{t("scenario.checks")}</summary>
          <ul lang="en">
            {checks.map(({ figure, held, name }) => (
              <li key={name}>
                <strong class={held ? "" : "tone-alarm"}>{held ? "✓" : "✗"}</strong> {name}
                <small class="muted">{figure}</small>
              </li>
            ))}
          </ul>
        </details>
      )}
    </Card>
  );
}

function Line({ step, isNext, isOver }: { step: StepView; isNext: boolean; isOver: boolean }) {
  const { after_s: afterS, agents } = step;
  const when = afterS !== null ? format.duration(afterS) : isNext ? t("scenario.next") : isOver ? t("scenario.never") : "";
  return (
    <li class={afterS === null ? "todo" : ""} aria-current={isNext ? "step" : undefined}>
      <span>
        {t(`scenario.step.${step.step}`)}
        {agents.length > 0 && ":"}
        {agents.map((agent) => (
          <Agent key={agent} id={agent} />
        ))}
      </span>
      <small>{when}</small>
    </li>
  );
}

function Agent({ id }: { id: string }) {
  const kind = world.value?.atvs.has(id) ? "atv" : world.value?.machines.has(id) ? "machine" : null;
  if (kind === null) return <> {id}</>;
  return (
    <>
      {" "}
      <button type="button" class="link" onClick={() => { choose({ kind, id }); }}>
        {id}
      </button>
    </>
  );
}
