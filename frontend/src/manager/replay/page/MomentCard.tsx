import { useSignal, useSignalEffect } from "@preact/signals";
import { whatText } from "../../../alerts/alert-text";
import { inOrder } from "../../../alerts/alerts";
import type { TaskView } from "../../../api/types";
import { Card } from "../../../parts/Card";
import { Tag } from "../../../parts/Tag";
import { choose, NOTHING, selection } from "../../../selection/selection";
import { format, t } from "../../../text/views/replay";
import { factoryTime } from "../../../text/plant-time";
import { orderOf, subjectOf } from "../../alerts/subject";
import { whyText } from "../../cards/auction/why-text";
import { loadOf, placeOf } from "../../orders/page/moments";
import { problemText } from "../../problem-text";
import { addressOf } from "../../views";
import { fetchKnowledge, type Knowledge } from "./api";
import { KnowledgeTable } from "./KnowledgeTable";
import { atS, past, secondS } from "./state";

/** People who drag ask for the last moment only. */
const SETTLE_MS = 250;
const TASKS_SHOWN = 40;

/** What was wrong, what was offered and carried, or what one agent knew. */
export function MomentCard() {
  const chosen = selection.value;
  const agent = (chosen.latest === "atv" || chosen.place === null ? chosen.atv : chosen.place.id) ?? "";
  const knowledge = useSignal<Knowledge | null>(null);
  const failed = useSignal<string | null>(null);
  useSignalEffect(() => {
    const { atv, latest, place } = selection.value;
    const asked = (latest === "atv" || place === null ? atv : place.id) ?? "";
    const at = secondS.value;
    if (asked === "" || at <= 0) return undefined;
    let shown = true;
    const timer = setTimeout(() => {
      fetchKnowledge(asked, atS.peek()).then(
        (found) => {
          if (!shown) return;
          knowledge.value = found;
          failed.value = null;
        },
        (error: unknown) => {
          if (shown) failed.value = problemText(error);
        },
      );
    }, SETTLE_MS);
    return () => {
      shown = false;
      clearTimeout(timer);
    };
  });
  const aside = (
    <span class="segments" role="group" aria-label={t("replay.whose")}>
      <button type="button" aria-pressed={agent === ""} onClick={() => (selection.value = NOTHING)}>
        {t("replay.all")}
      </button>
      {agent !== "" && (
        <button type="button" aria-pressed={true}>
          {agent}
        </button>
      )}
    </span>
  );
  return (
    <Card title={t("replay.moment")} class="replay-moment" aside={aside} scrolls>
      {agent === "" ? (
        <Everything />
      ) : failed.value !== null ? (
        <p class="empty" role="status">
          {failed.value}
        </p>
      ) : (
        knowledge.value?.agent === agent && <KnowledgeTable knowledge={knowledge.value} />
      )}
    </Card>
  );
}

function Everything() {
  const world = past.value;
  if (world === null) return null;
  const alerts = inOrder(world.alerts.values());
  const tasks = [...world.tasks.values()].filter((task) => task.closed_at_s === null).reverse();
  return (
    <>
      <p class="muted replay-hint">{t("replay.choose")}</p>
      <h3>{t("replay.alerts")}</h3>
      {alerts.length === 0 && <p class="empty">{t("replay.noAlerts")}</p>}
      <ul class="replay-list">
        {alerts.map((alert) => (
          <li key={alert.id}>
            <Tag tone={alert.level === "alarm" ? "alarm" : "warn"}>{t(`alerts.kind.${alert.level}`)}</Tag>
            <span>
              {orderOf(alert) === "" ? <b>{subjectOf(alert)}</b> : <a class="link" href={addressOf(orderOf(alert))}>{subjectOf(alert)}</a>}{" "}
              {whatText(alert, world.atS, world.factory.speed)}
            </span>
          </li>
        ))}
      </ul>
      <h3>{t("replay.tasks")}</h3>
      {tasks.length === 0 && <p class="empty">{t("replay.noTasks")}</p>}
      <ul class="replay-list">
        {tasks.slice(0, TASKS_SHOWN).map((task) => (
          <Task key={task.id} task={task} />
        ))}
      </ul>
    </>
  );
}

function Task({ task }: { task: TaskView }) {
  const load = loadOf(task.item, task.quantity);
  const line = t("replay.taskLine", {
    item: load,
    from: placeOf(task.source || (task.sources[0] ?? "")),
    to: placeOf(task.destination || task.coordinator),
  });
  const carried = task.secondary === "" ? "replay.carriedBy" : "replay.carriedWatched";
  const state =
    task.state === "bidding"
      ? t("replay.bidding", { n: format.count(task.bids.filter((bid) => bid.round === task.round && bid.epoch === task.epoch).length) })
      : t(carried, { carrier: task.primary, watcher: task.secondary });
  return (
    <li>
      <details>
        <summary>
          <b>{task.kind === "transport" ? line : load}</b> <span class="muted">{state}</span>
        </summary>
        <p>{whyText(task, past.value?.factory.speed)}</p>
        {task.primary !== "" && task.kind === "transport" && (
          <button type="button" class="link" onClick={() => { choose({ kind: "atv", id: task.primary }); }}>
            {task.primary}
          </button>
        )}
        <ol class="replay-bids">
          {task.bids.map((bid, index) => (
            <li key={index} class="num">
              {bid.bidder} {factoryTime(bid.total_s, past.value?.factory.speed, "price")}
            </li>
          ))}
        </ol>
      </details>
    </li>
  );
}
