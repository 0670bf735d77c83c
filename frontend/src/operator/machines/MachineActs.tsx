import type { MachineView } from "../../api/types";
import { format, t } from "../../text/operator";
import { inFactoryTime } from "../../text/plant-time";
import { Leaving } from "../cards/HandOver";
import { Patience, promise } from "../cards/HelpAsk";
import { ServiceActs } from "../cards/Service";
import { giveMachine } from "../commands/given";
import { hasCallCard } from "../duty/duty";
import { circumstancesOf, moment } from "../state";
import type { MachineNeed } from "./need";

/** How long it takes to walk over and put something right. */
const MINUTES = [2, 5, 10, 15];

/** Parts of its own speed. */
const STEPS = [0.25, 0.5, 0.75, 1];
const SAME = 1e-6;

/** What a person may ask of a machine; only the machine itself refuses. */
export function MachineActs({ machine, need }: { machine: MachineView; need: MachineNeed }) {
  const { connected, ended, lost } = circumstancesOf(machine);
  const disabled = ended || !connected || lost;
  const { help, id } = machine;
  const leftS = help === null ? 0 : (help.until_at_s - moment.value.nowS) * moment.value.speed;
  return (
    <>
      {help !== null && (
        <div class="help">
          {leftS > 0 ? <Patience help={help} leftS={leftS} waits={t("machine.waits")} coming="machine.coming" /> : <p>{t("machine.over")}</p>}
          <Promises machine={machine} disabled={disabled} />
          <Leaving
            disabled={disabled || machine.goals.length === 0}
            text={(leaving) => t(leaving ? "handOver.leaving" : "machine.handOver")}
            onGone={() => void giveMachine(id, { kind: "hand_over" })}
          />
        </div>
      )}
      {machine.problem !== "" && (
        <button
          type="button"
          class={`button fault-gone ${need === "reset" ? "primary" : ""}`}
          disabled={disabled || !machine.resettable}
          onClick={() => void giveMachine(id, { kind: "clear_fault" })}
        >
          <b>{t("release.acknowledge")}</b>
          <small>{t(machine.resettable ? "machine.worksAgain" : "machine.notYet")}</small>
        </button>
      )}
      <div class="steps" role="group" aria-label={t("machine.speed", { id })}>
        <span aria-hidden="true">{t("steps.short")}</span>
        {STEPS.map((step) => (
          <button
            key={step}
            type="button"
            aria-pressed={Math.abs(machine.speed_frac - step) < SAME}
            disabled={disabled}
            onClick={() => void giveMachine(id, { kind: "set_speed", speed_frac: step })}
          >
            {format.percent(step)}
          </button>
        ))}
      </div>
      <div class="software" role="group" aria-label={t("machine.software", { id, version: machine.software })}>
        {(["restart", "update"] as const).map((kind) => (
          <button key={kind} type="button" class="button" disabled={disabled} onClick={() => void giveMachine(id, { kind })}>
            {t(`command.${kind}`)}
          </button>
        ))}
      </div>
      <ServiceActs
        id={id}
        out={machine.out_of_service}
        hindered={disabled || (machine.out_of_service !== null && machine.problem !== "")}
        finishes={machine.goals.length > 0 ? t("machine.afterWork") : null}
        checks={[t("check.machine.tools"), t("check.machine.guards"), t("check.machine.material")]}
        send={(word) => void giveMachine(id, word)}
      />
    </>
  );
}

function Promises({ disabled, machine }: { machine: MachineView; disabled: boolean }) {
  if (hasCallCard(machine.id)) return null;
  const promised = (machine.help?.promised_by ?? "") !== "";
  const title = inFactoryTime(t(promised ? "help.later" : "help.onMyWay"));
  return (
    <div class="promises" role="group" aria-label={title}>
      <span aria-hidden="true">{title}</span>
      {MINUTES.map((minutes) => (
        <button
          key={minutes}
          type="button"
          class={`button ${promised ? "" : "primary"}`}
          disabled={disabled}
          onClick={() => {
            promise(machine.id, minutes * 60, () => giveMachine(machine.id, { kind: "promise", wait_s: minutes * 60 }));
          }}
        >
          <span class="unseen">{t("help.there", { atv: machine.id })}</span> {t("help.in", { minutes })}
        </button>
      ))}
    </div>
  );
}
