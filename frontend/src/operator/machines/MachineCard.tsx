import type { MachineView } from "../../api/types";
import { Tag } from "../../parts/Tag";
import { world } from "../../stream/stream";
import { vehicleName } from "../../text/elsewhere";
import { failureText } from "../../text/failure";
import { format, t } from "../../text/operator";
import { knownText } from "../cards/HelpAsk";
import { CommandLine } from "../commands/CommandLine";
import { moment, names, plant } from "../state";
import { MachineActs } from "./MachineActs";
import { type MachineNeed, machineNeedOf, sinceS, waitingGoals } from "./need";

const TONES = { help: "warn", coming: "warn", reset: "warn", lost: "alarm", out: "normal", well: "normal" } as const;

/** One machine that needs somebody, or is out of service: what is wrong, what waits for it, and what a person may ask of it. */
export function MachineCard({ machine }: { machine: MachineView }) {
  const need = machineNeedOf(machine, moment.value);
  const spec = plant.value?.machines.find(({ id }) => id === machine.id);
  return (
    <li class={`vehicle card machine-need need-${NEED_CLASS[need]}`} id={`machine-${machine.id}`}>
      <div class="vehicle-body">
        <header>
          <h2>
            {machine.id} <span class="title-more">{spec?.name ?? machine.name}</span>
          </h2>
          <Tag tone={TONES[need]}>{t(`machine.need.${need}`)}</Tag>
          <span class="where num">{t("machine.since", { at: format.due(sinceS(machine), moment.value.nowS) })}</span>
        </header>
        <div class="vehicle-now">
          {machine.problem !== "" && <p class="help-what">{t("help.what", { problem: failureText(machine.problem) })}</p>}
          {machine.about_problem && <p class="help-known">{knownText(machine.about_problem)}</p>}
          <p class="doing">{goalsText(machine)}</p>
          <WaitingGoals machine={machine} />
          <Coming machine={machine} />
        </div>
        <div class="vehicle-acts">
          <MachineActs machine={machine} need={need} />
        </div>
        <CommandLine atv={machine.id} stopped={false} />
      </div>
    </li>
  );
}

/** A card of a machine looks like that of a vehicle with the same need. */
const NEED_CLASS: Readonly<Record<MachineNeed, string>> = {
  help: "help", coming: "coming", reset: "stopped", lost: "lost", out: "out", well: "working",
};

/** More than are read at a glance; the rest is counted. */
const GOALS_SHOWN = 3;

function goalsText(machine: MachineView): string {
  const { firstAtS, goals } = waitingGoals(machine);
  if (goals.length === 0) return t("machine.noGoals");
  const many = goals.length === 1 ? t("machine.oneGoal") : t("machine.goals", { count: format.count(goals.length) });
  const due = firstAtS === null ? "" : ` ${t("machine.firstDue", { at: format.due(firstAtS, moment.value.nowS) })}`;
  const offered = machine.goals.some((goal) => goal.offered) ? ` ${t("machine.offered")}` : "";
  return `${many}${due}${offered}`;
}

/** Which goals wait, and for which orders. */
function WaitingGoals({ machine }: { machine: MachineView }) {
  const { goals } = waitingGoals(machine);
  if (goals.length === 0) return null;
  return (
    <ul class="coming">
      {goals.slice(0, GOALS_SHOWN).map(({ goal, made, order_due_at_s: dueS, order_name: order, product, quantity }) => (
        <li key={goal}>
          {t("machine.goal", { item: names.value(product), made: format.count(made), quantity: format.count(quantity) })}
          {order !== "" && ` · ${t("machine.order", { order })}`}
          {dueS !== null && ` · ${t("station.orderDue", { at: format.due(dueS, moment.value.nowS) })}`}
        </li>
      ))}
      {goals.length > GOALS_SHOWN && <li class="muted">{t("machine.moreGoals", { count: format.count(goals.length - GOALS_SHOWN) })}</li>}
    </ul>
  );
}

/** Who brings material, and who is behind them. */
function Coming({ machine }: { machine: MachineView }) {
  const coming = machine.tasks.filter(({ destination, primary }) => destination === machine.id && primary !== "");
  if (coming.length === 0) return null;
  return (
    <ul class="coming">
      {coming.map(({ item, primary, quantity, secondary, task }) => {
        const due = world.value?.atvs.get(primary)?.task?.due_at_s;
        const what = { quantity: format.count(quantity), item: names.value(item), atv: vehicleName(primary) };
        return (
          <li key={task}>
            {t("machine.brings", what)}
            {due && ` · ${t("card.there", { at: format.due(due, moment.value.nowS) })}`}
            {secondary !== "" && <span class="muted"> · {t("machine.secondary", { atv: vehicleName(secondary) })}</span>}
          </li>
        );
      })}
    </ul>
  );
}
