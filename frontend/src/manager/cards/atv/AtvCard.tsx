import type { AtvView, TaskView } from "../../../api/types";
import { batteryText } from "../../../parts/battery";
import { BodyWait } from "../../../parts/BodyWait";
import { Card } from "../../../parts/Card";
import { Carrying } from "../../../parts/Carrying";
import { Fact, Facts } from "../../../parts/Facts";
import { Link } from "../../../parts/Link";
import { Meter } from "../../../parts/Meter";
import { Tag, toneOfAtv } from "../../../parts/Tag";
import { isLost } from "../../../plant/silence";
import { selection } from "../../../selection/selection";
import { nowS, presentS, world } from "../../../stream/stream";
import { failureText } from "../../../text/failure";
import { sinceHeard } from "../../../text/heard";
import { format, t, word } from "../../../text/manager";
import { ClockFact } from "../agents/ClockMark";
import { ShutOutMenu } from "../agents/ShutOutMenu";
import { CommandMenu } from "../commands/CommandMenu";
import { ShutOutNote } from "../agents/ShutOutNote";
import { UpdateFact } from "../agents/UpdateFact";
import { Later } from "../../../parts/Later";
import { problemText } from "../../problem-text";
import { names, plant } from "../../state";
import { Term } from "../../story/Term";
import { doingText } from "./doing";
import { FaultFacts, FaultMenu } from "../faults/FaultParts";
import { HelpWanted } from "./HelpWanted";
import { linkText } from "./link";
import { Promise as PromiseFact } from "./Promise";
import { WaitNote } from "./WaitNote";

/** Bottom right: the chosen vehicle. */
export function ChosenAtv() {
  const atv = world.value?.atvs.get(selection.value.atv ?? "");
  if (atv) return <AtvCard atv={atv} />;
  return (
    <Card title={t("atv.title")} class="atv">
      <p class="empty">{t("atv.none")}</p>
    </Card>
  );
}

function AtvCard({ atv }: { atv: AtvView }) {
  const type = plant.value?.vehicle_types.find((each) => each.id === atv.type);
  const task = atv.task && world.value?.tasks.get(atv.task.task);
  const speed = world.value?.factory.speed ?? 1;
  const lost = isLost(atv, presentS.value, speed);
  const wait = world.value?.waits.get(atv.id);
  const most = format.number((type?.max_speed_mps ?? 0) * atv.speed_limit_frac, 1);
  return (
    <Card
      title={
        <>
          {atv.id} <span class="title-more">{type?.name}</span>
        </>
      }
      aside={<Status atv={atv} lost={lost} />}
      class={`atv ${lost ? "silent" : ""}`}
      scrolls
      foot={
        atv.shut_out ? undefined : (
          <>
            <CommandMenu key={atv.id} atv={atv.id} />
            <ShutOutMenu key={atv.id} agent={atv.id} kind="atv" />
          </>
        )
      }
    >
      {atv.shut_out && <ShutOutNote agent={atv.id} kind="atv" out={atv.shut_out} />}
      {atv.problem && !atv.shut_out && (
        <div class="problem">
          {failureText(atv.problem)}
          {atv.help && <HelpWanted atv={atv.id} help={atv.help} speed={speed} />}
        </div>
      )}
      {wait && <WaitNote wait={wait} />}
      {!lost && <BodyWait atv={atv} nowS={presentS.value} speed={speed} />}
      <Carrying
        key={atv.id}
        atv={atv}
        atvs={world.value?.atvs.values() ?? []}
        isSimulated={world.value?.fault_injection ?? false}
        plant={plant.value}
        nowS={presentS.value}
        speed={speed}
        problemText={problemText}
      />
      <div class="recent-place">
        <Later load={async () => (await import("../strip/RecentStrip")).loadAtv()} />
      </div>
      <Facts>
        <FaultFacts agent={atv.id} />
        <UpdateFact agent={atv} />
        <Fact name={t("atv.status")}>
          {doingText(atv)}
          {atv.in_reserve && (
            <small>
              {t("atv.reserve")}: {t("atv.reserveWhy")}
            </small>
          )}
        </Fact>
        <TaskFacts atv={atv} task={task ?? undefined} lost={lost} />
        <WatchFacts atv={atv} task={task ?? undefined} />
        <Fact name={t("atv.load")}>
          {atv.load === ""
            ? t("atv.empty")
            : t("atv.loadOf", { quantity: format.count(atv.load_quantity), item: names.value(atv.load) })}
        </Fact>
        <Fact name={t("atv.speed")}>{t("atv.speedOf", { speed: format.number(atv.speed_mps, 1), most })}</Fact>
        <Fact name={t("atv.heartbeat")}>
          <span class={lost ? "tone-alarm" : atv.link === "mesh" ? "tone-warn" : ""}>
            {t("atv.heardBy", { age: sinceHeard(nowS.value - atv.seen_at_s), link: lost ? t("atv.noLink") : linkText(atv) })}
          </span>
        </Fact>
        <ClockFact clock={atv.clock} />
      </Facts>
      <div class="stock-row battery">
        <span>{t("atv.battery")}</span>
        <Meter
          frac={atv.battery_frac}
          label={batteryText(atv)}
          tone={atv.battery_frac < 0.2 ? "warn" : "normal"}
        />
        <span class="num">{batteryText(atv)}</span>
      </div>
    </Card>
  );
}

function Status({ atv, lost }: { atv: AtvView; lost: boolean }) {
  return (
    <>
      <FaultMenu agent={atv.id} kind="atv" />
      {lost ? <Tag tone="alarm">{t(atv.shut_out ? "atv.shut_out" : "atv.lost")}</Tag> : <Tag tone={toneOfAtv(atv.status)}>{word("atv", atv.status)}</Tag>}
    </>
  );
}

function TaskFacts({ atv, lost, task }: { atv: AtvView; task: TaskView | undefined; lost: boolean }) {
  const brief = atv.task;
  if (!brief) return <Fact name={t("atv.task")}>{t("atv.noTask")}</Fact>;
  const quantity = format.count(brief.quantity);
  return (
    <>
      <Fact name={t("atv.task")}>
        <Link kind="task" id={brief.task} /> · <Term name="epoch">{t("auction.epoch", { epoch: brief.epoch })}</Term>
      </Fact>
      <Fact name={t("atv.for")}>
        <Link kind="machine" id={brief.coordinator} /> · {t("atv.loadOf", { quantity, item: names.value(brief.item) })}
      </Fact>
      <PromiseFact atv={atv} lost={lost} promisedAtS={task?.promised_at_s ?? null} />
    </>
  );
}

function WatchFacts({ atv, task }: { atv: AtvView; task: TaskView | undefined }) {
  const watcher = world.value?.atvs.get(task?.secondary ?? "");
  return (
    <>
      {task?.primary === atv.id && (
        <Fact name={t("atv.watchedBy")}>
          {watcher ? (
            <>
              <Link kind="atv" id={watcher.id} /> · {t("machine.ago", { age: sinceHeard(nowS.value - watcher.seen_at_s) })}
            </>
          ) : (
            t("atv.nobody")
          )}
        </Fact>
      )}
      <Fact name={t("atv.watches")}>
        {atv.watches.length === 0 ? t("atv.nothing") : atv.watches.map((brief) => <Watched key={brief.task} id={brief.task} />)}
      </Fact>
    </>
  );
}

function Watched({ id }: { id: string }) {
  const primary = world.value?.tasks.get(id)?.primary ?? "";
  return <span class="line">{primary === "" ? <Link kind="task" id={id} /> : <Link kind="atv" id={primary} />}</span>;
}
