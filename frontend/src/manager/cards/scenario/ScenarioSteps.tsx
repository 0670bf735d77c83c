import { useSignal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect, useRef } from "preact/hooks";
import { skipToNextStep } from "../../../api/client";
import type { ScenarioView, StepView } from "../../../api/types";
import { Card } from "../../../parts/Card";
import { choose } from "../../../selection/selection";
import { presentS, world } from "../../../stream/stream";
import { speakAlso } from "../../../text/speech";
import { factoryTime, inFactoryTime } from "../../../text/plant-time";
import { format, t, tables } from "../../../text/views/scenario";
import { problemText } from "../../problem-text";
import { leftS, nextOf } from "./steps";

/** The card, once it has its words. */
export async function load(): Promise<typeof ScenarioSteps> {
  await speakAlso(tables);
  return ScenarioSteps;
}

/** Which steps have happened and when, which one is next and when, how it ended. */
export function ScenarioSteps({ scenario }: { scenario: ScenarioView }) {
  const { after_s: afterS, checks, id, state, steps } = scenario;
  const next = nextOf(scenario);
  return (
    <Card class="scenario" title={inFactoryTime(t("scenario.title", { name: id }))} scrolls>
      {state === "playing" && <Skip isSkipping={scenario.skipping} />}
      <ol>
        {steps.map((step) => (
          <Line key={step.step} step={step} when={step === next ? <Countdown scenario={scenario} step={step} /> : whenOf(step, state !== "playing")} isNext={step === next} />
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

function Line({ step, when, isNext }: { step: StepView; when: ComponentChildren; isNext: boolean }) {
  const { after_s: afterS, agents } = step;
  const line = useRef<HTMLLIElement>(null);
  useEffect(() => { if (isNext && line.current) showWithin(line.current); }, [isNext]);
  return (
    <li ref={line} class={afterS === null ? "todo" : ""} aria-current={isNext ? "step" : undefined}>
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

/** Scrolls a card until a line of it is in the middle; the page around the card stays where it is. */
function showWithin(line: HTMLElement): void {
  const body = line.closest(".card-body");
  if (!body) return;
  const [inner, outer] = [line.getBoundingClientRect(), body.getBoundingClientRect()];
  body.scrollTop += inner.top - outer.top - (outer.height - inner.height) / 2;
}

function whenOf({ after_s: afterS }: StepView, isOver: boolean): string {
  if (afterS !== null) return format.duration(afterS);
  return isOver ? t("scenario.never") : "";
}

/** How long until the next step, where a rehearsal has told it. */
function Countdown({ scenario, step }: { scenario: ScenarioView; step: StepView }) {
  const left = leftS(step, scenario, presentS.value, world.value?.factory.speed ?? 1);
  if (left === null) return <>{t("scenario.next")}</>;
  return <>{left > 0 ? t("scenario.in", { time: format.duration(left) }) : t("scenario.late")}</>;
}

function Skip({ isSkipping }: { isSkipping: boolean }) {
  const busy = useSignal(false);
  const failed = useSignal("");
  const act = (): void => {
    busy.value = true;
    failed.value = "";
    void skipToNextStep(!isSkipping)
      .catch((error: unknown) => { failed.value = t("scenario.skipFailed", { reason: problemText(error) }); })
      .finally(() => { busy.value = false; });
  };
  return (
    <div class="to-next">
      <button type="button" class="button small" disabled={busy.value} title={t("scenario.skipHint")} onClick={act}>
        {t(isSkipping ? "scenario.skipping" : "scenario.skip")}
      </button>
      {failed.value !== "" && <p role="alert" class="tone-alarm">{failed.value}</p>}
    </div>
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
