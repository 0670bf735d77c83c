import type { MachineSpec, MachineView, OpenTaskView } from "../../../api/types";
import { Card } from "../../../parts/Card";
import { Documents } from "../../../parts/Documents";
import { Fact, Facts } from "../../../parts/Facts";
import { Link } from "../../../parts/Link";
import { Meter } from "../../../parts/Meter";
import { Tag, toneOfMachine } from "../../../parts/Tag";
import { isLost } from "../../../plant/silence";
import { nowS, presentS, world } from "../../../stream/stream";
import { causeText, failureText } from "../../../text/failure";
import { sinceHeard } from "../../../text/heard";
import { format, n, t, word } from "../../../text/manager";
import { ClockFact } from "../agents/ClockMark";
import { ShutOutMenu } from "../agents/ShutOutMenu";
import { ShutOutNote } from "../agents/ShutOutNote";
import { UpdateFact } from "../agents/UpdateFact";
import { Later } from "../../../parts/Later";
import { names } from "../../state";
import { FaultFacts, FaultMenu } from "../faults/FaultParts";
import { CallHere } from "./CallHere";
import { Doubts } from "./Doubts";
import { Stock } from "./Stock";

const loadPieces = async () => (await import("../../../parts/pieces/Pieces")).load();
const nameOf = (product: string): string => names.value(product);

/** The chosen machine: what it makes, what it needs, who brings it. */
export function MachineCard({ spec, machine }: { spec: MachineSpec; machine: MachineView | undefined }) {
  const status = machine?.status;
  const lost = machine !== undefined && isLost(machine, presentS.value, world.value?.factory.speed ?? 1);
  return (
    <Card
      title={
        <>
          {spec.id} <span class="title-more">{spec.name}</span>
        </>
      }
      aside={
        <>
          <FaultMenu agent={spec.id} kind="machine" />
          {lost ? <Tag tone="alarm">{t(machine.shut_out ? "machine.shut_out" : "machine.lost")}</Tag> : status && <Tag tone={toneOfMachine(status)}>{word("machine", status)}</Tag>}
        </>
      }
      class={`machine ${lost ? "silent" : ""}`}
      scrolls
      foot={
        <>
          <CallHere key={spec.id} place={spec.id} />
          {machine && !machine.shut_out && <ShutOutMenu key={spec.id} agent={spec.id} kind="machine" />}
        </>
      }
    >
      {machine?.shut_out && <ShutOutNote agent={spec.id} kind="machine" out={machine.shut_out} />}
      {machine?.problem && !machine.shut_out && <p class="problem">{failureText(machine.problem)}</p>}
      <div class="recent-place">
        <Later load={async () => (await import("../strip/RecentStrip")).loadMachine()} />
      </div>
      <Facts>
        <FaultFacts agent={spec.id} />
        {machine && <UpdateFact agent={machine} />}
        <Goal machine={machine} />
        <Task machine={machine} />
        {machine?.waits && (
          <Fact name={t("machine.waits")}>
            <span class="tone-warn">{causeText(machine.waits)}</span>
          </Fact>
        )}
        <Fact name={t("machine.heartbeat")}>
          <span class={lost ? "tone-alarm" : ""}>
            {machine ? t("machine.ago", { age: sinceHeard(nowS.value - machine.seen_at_s) }) : t("machine.never")}
          </span>
        </Fact>
        <ClockFact clock={machine?.clock} />
      </Facts>
      <Documents machine={machine} name={nameOf} />
      <Doubts agent={spec.id} station={false} doubts={machine?.doubts ?? []} />
      <Stock title={t("machine.buffers")} buffers={machine?.buffers ?? []} />
      <Stock title={t("machine.goods")} buffers={machine?.goods ?? []} />
      <Later load={loadPieces} of={{ machine: spec.id, name: nameOf }} />
      <Transports tasks={byDeadline(machine).slice(1)} />
    </Card>
  );
}

function Goal({ machine }: { machine: MachineView | undefined }) {
  const goal = machine?.goals[0];
  const more = (machine?.goals.length ?? 0) - 1;
  if (!goal) return <Fact name={t("machine.goal")}>{t("machine.noGoal")}</Fact>;
  const made = t("machine.goalOf", { made: format.count(goal.made), quantity: format.count(goal.quantity) });
  return (
    <Fact name={t("machine.goal")}>
      {names.value(goal.product)} · {made}
      <Meter frac={goal.delivered / goal.quantity} behind={goal.made / goal.quantity} label={made} tone="done" />
      {more > 0 && <small>{n("machine.moreGoals", more)}</small>}
    </Fact>
  );
}

function byDeadline(machine: MachineView | undefined): OpenTaskView[] {
  return [...(machine?.tasks ?? [])].sort((a, b) => a.deadline_at_s - b.deadline_at_s);
}

/** The most urgent transport; the others follow below. */
function Task({ machine }: { machine: MachineView | undefined }) {
  const task = byDeadline(machine)[0];
  if (!machine || !task) return <Fact name={t("machine.needs")}>{t("machine.needsNothing")}</Fact>;
  const out = task.destination !== machine.id;
  return (
    <>
      <Fact name={t(out ? "machine.sends" : "machine.needs")}>
        {t("machine.needsBy", {
          quantity: format.count(task.quantity),
          item: names.value(task.item),
          by: format.clock(task.deadline_at_s),
        })}
      </Fact>
      <Contractors task={task} />
      {task.trouble !== null && (
        <Fact name={t("machine.trouble")}>
          <span class="tone-warn">{causeText(task.trouble)}</span>
        </Fact>
      )}
    </>
  );
}

function Contractors({ task }: { task: OpenTaskView }) {
  const who = (id: string) => (id === "" ? t("machine.nobody") : <Link kind="atv" id={id} />);
  return (
    <>
      <Fact name={t("machine.primary")}>{who(task.primary)}</Fact>
      <Fact name={t("machine.secondary")}>{who(task.secondary)}</Fact>
    </>
  );
}

/** The other open transports, in short. */
function Transports({ tasks }: { tasks: readonly OpenTaskView[] }) {
  if (tasks.length === 0) return null;
  return (
    <div class="stock">
      <h3>{n("machine.moreTasks", tasks.length)}</h3>
      <Facts>
        {tasks.map((task) => (
          <Fact key={task.task} name={t("atv.loadOf", { quantity: format.count(task.quantity), item: names.value(task.item) })}>
            <Link kind="task" id={task.task} />
          </Fact>
        ))}
      </Facts>
    </div>
  );
}
