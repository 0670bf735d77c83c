import { fetchTaskStory, type TaskStory as Story } from "../../../../api/transports";
import { Card } from "../../../../parts/Card";
import "../../../../parts/paper.css";
import { Tag } from "../../../../parts/Tag";
import { choose } from "../../../../selection/selection";
import { nowS, world } from "../../../../stream/stream";
import { causeText } from "../../../../text/failure";
import { speakAlso } from "../../../../text/speech";
import { t as ofOrders, tables as orderTables } from "../../../../text/views/order";
import { t as ofTasks, tables as taskTables } from "../../../../text/views/records";
import { format, t, tables, word } from "../../../../text/views/transports";
import { isOpen } from "../../../cards/auction/auction";
import { LoadSeen } from "../../../cards/auction/LoadSeen";
import { whyText } from "../../../cards/auction/why-text";
import { WaitNote } from "../../../cards/atv/WaitNote";
import { Figure } from "../../../orders/page/Head";
import { spanBetween } from "../../../orders/page/lanes";
import { TransportLanes } from "../../../orders/page/Lanes";
import { Moments } from "../../../orders/page/Moments";
import { Legend, Told } from "../../../orders/page/OrderStory";
import { loadOf, placeOf } from "../../../orders/page/moments";
import { StoryFrame } from "../../../orders/page/StoryFrame";
import { printPage } from "../../../parts/paper/printing";
import { useRefreshed } from "../../../refreshed";
import { placesOf } from "../../../state";
import { addressOf, go, shownTransport } from "../../../views";
import { Result } from "../../tasks/Result";
import { Steps } from "./Steps";
import { attemptsOf, carriersOf, sourceOf, stateOf, stepsOf } from "./story";

/** As of a plain transport. */
const AGAIN_MS = 3000;

/** The page, once it has its words. */
export async function load(): Promise<typeof TaskStory> {
  await Promise.all([speakAlso(tables), speakAlso(orderTables), speakAlso(taskTables)]);
  return TaskStory;
}

/** What a machine has brought for itself, or has fetched: who carries it, why it waits, and when it is there. */
export function TaskStory() {
  const id = shownTransport.value;
  const { answer, failed } = useRefreshed(() => fetchTaskStory(shownTransport.value), AGAIN_MS);
  const story = answer.value?.transport.id === id ? answer.value : null;
  return (
    <StoryFrame
      id={id}
      failed={failed.value === null ? null : t("called.page.failed", { reason: failed.value })}
      loading={t("view.loading")}
      back={{ href: "#tasks", text: t("called.task.all") }}
    >
      {story && (
        <>
          <Head story={story} />
          <div class="order-columns">
            <div class="order-main">
              <LanesCard story={story} />
              <Moments moments={story.moments} partly={story.is_whole ? "" : t("called.page.partly")} />
            </div>
            <div class="order-side">
              <Waits story={story} />
            </div>
          </div>
        </>
      )}
    </StoryFrame>
  );
}

/** When it is there, as its carrier has promised; null as long as nobody has, and where that is not kept. */
function promisedS({ transport: { id, promised_at_s: keptS } }: Story): number | null {
  return world.value?.tasks.get(id)?.promised_at_s ?? keptS;
}

/** Answers first what people come for: where it is, and when it is there. */
function Head({ story }: { story: Story }) {
  const { closed_at_s: closedS, coordinator, destination, id, item, opened_at_s: openedS, order, quantity, reference, standby } = story.transport;
  const { before, last } = carriersOf(story);
  const atS = promisedS(story);
  const state = stateOf(story);
  return (
    <section class="card order-head" aria-labelledby="transport-title">
      <div class="order-title">
        <p class="muted">
          <a class="quiet-link" href="#tasks">
            {ofTasks("tasks.title")}
          </a>
          {` / ${id}`}
        </p>
        <h1 id="transport-title">
          {t("called.page.what", { load: loadOf(item, quantity), from: placesOf(sourceOf(story)), to: placeOf(destination) })}
        </h1>
        <Tag tone={state === "cancelled" ? "warn" : "normal"}>{word("called.is", state)}</Tag>
        <div class="order-deeds">
          {world.value?.tasks.has(id) === true && (
            <button type="button" class="button small" onClick={() => { choose({ kind: "task", id }); go("plant"); }}>
              {ofOrders("orderPage.show")}
            </button>
          )}
          <button type="button" class="button small" onClick={() => void printPage()}>
            {ofOrders("orderPage.print")}
          </button>
        </div>
      </div>
      <dl class="order-figures">
        <Figure head={ofTasks("tasks.opened")} more={coordinator}>{format.due(openedS, nowS.value)}</Figure>
        <Steps {...stepsOf(story)} />
        {order !== "" && (
          <Figure head={ofTasks("tasks.order")}>
            <a class="link" href={addressOf(order)}>{reference ?? order}</a>
          </Figure>
        )}
        <Figure head={ofTasks("tasks.promise")} more={<Result task={story.transport} />}>{atS === null ? "–" : format.due(atS, nowS.value)}</Figure>
        {closedS !== null && (
          <Figure head={state === "delivered" ? ofOrders("orderPage.deliveredAt") : t("called.page.ended")}>
            {format.due(closedS, nowS.value)}
          </Figure>
        )}
        <Figure head={t("called.page.carrier")} more={before.length === 0 ? "" : t("called.page.before", { carriers: format.list(before) })}>
          {last === "" ? t("called.page.nobody") : last}
        </Figure>
        {closedS === null && standby !== "" && <Figure head={ofTasks("tasks.secondary")}>{standby}</Figure>}
      </dl>
    </section>
  );
}

function LanesCard({ story }: { story: Story }) {
  const { closed_at_s: closedS, opened_at_s: openedS } = story.transport;
  const untilS = closedS ?? nowS.value;
  const atS = promisedS(story);
  const expectedS = closedS === null ? atS : null;
  const ends = [untilS, expectedS ?? untilS, ...story.moments.map((moment) => moment.at_s)];
  return (
    <Card title={t("called.page.lanes")} class="order-lanes">
      {!story.is_whole && <p class="muted">{t("called.page.forgotten")}</p>}
      <TransportLanes
        attempts={attemptsOf(story, untilS)}
        span={spanBetween(openedS, ends, closedS !== null)}
        nowS={closedS === null ? nowS.value : Infinity}
        dueS={null}
        expected={expectedS === null ? null : { from_at_s: expectedS, to_at_s: expectedS }}
      />
      <Legend kinds={["fetch", "carry", "lost", ...(expectedS === null ? [] : ["expected" as const]), ...(closedS === null ? ["now" as const] : [])]} />
      {story.attempts.map((attempt) => (
        <Told key={attempt.task} transport={attempt} />
      ))}
    </Card>
  );
}

/** Why it is not there yet: what is wrong, for whom its carrier stands, and why this one carries it. */
function Waits({ story: { transport } }: { story: Story }) {
  const task = world.value?.tasks.get(transport.id);
  if (task === undefined || !isOpen(task)) return null;
  const stands = world.value?.waits.get(task.primary);
  const why = whyText(task);
  const isHeld = task.trouble !== null || stands !== undefined;
  if (!isHeld && why === "") return null;
  return (
    <Card title={isHeld ? ofOrders("orderPage.waits") : t("called.vehicle")} class={isHeld ? "order-waits" : ""}>
      {task.trouble !== null && <p class="tone-warn">{causeText(task.trouble)}</p>}
      <LoadSeen key={task.id} task={task} />
      {stands && <WaitNote wait={stands} />}
      {why !== "" && <p class="muted">{why}</p>}
    </Card>
  );
}
