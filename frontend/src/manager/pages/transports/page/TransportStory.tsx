import { useSignal } from "@preact/signals";
import { callOff, fetchTransport, fetchTransportStory, makeTransportLink, revokeTransportLinks, type TransportAnswer, type TransportStory as Story } from "../../../../api/transports";
import { Card } from "../../../../parts/Card";
import "../../../../parts/paper.css";
import { Tag } from "../../../../parts/Tag";
import { choose } from "../../../../selection/selection";
import { nowS, world } from "../../../../stream/stream";
import { causeText } from "../../../../text/failure";
import { shortageText } from "../../../../text/shortage";
import { speakAlso } from "../../../../text/speech";
import { t as ofOrders, tables as orderTables } from "../../../../text/views/order";
import { format, t, tables, word } from "../../../../text/views/transports";
import { isOpen } from "../../../cards/auction/auction";
import { LoadSeen } from "../../../cards/auction/LoadSeen";
import { whyText } from "../../../cards/auction/why-text";
import { WaitNote } from "../../../cards/atv/WaitNote";
import { chosenTransport } from "../../../orders/page/address";
import { Figure } from "../../../orders/page/Head";
import { TransportLanes } from "../../../orders/page/Lanes";
import { LinkCard } from "../../../orders/page/LinkCard";
import { Moments } from "../../../orders/page/Moments";
import { Legend, Told } from "../../../orders/page/OrderStory";
import { loadOf, placeOf } from "../../../orders/page/moments";
import { StoryFrame } from "../../../orders/page/StoryFrame";
import { Sure } from "../../../parts/Sure";
import { problemText } from "../../../problem-text";
import { printPage } from "../../../parts/paper/printing";
import { useRefreshed } from "../../../refreshed";
import { go, shownTransport } from "../../../views";
import { canCallOff } from "../filter";
import { Steps } from "./Steps";
import { attemptsOf, carriersOf, expectedS, hasEnded, lateS, secondsOf, shownDueS, spanOf, stepsOf } from "./story";

/** A transport is looked at while it is brought, which takes minutes. */
const AGAIN_MS = 3000;

/** The page, once it has its words. */
export async function load(): Promise<typeof TransportStory> {
  await Promise.all([speakAlso(tables), speakAlso(orderTables)]);
  return TransportStory;
}

/** The plain transport that the address names: who has called for it, who carries it, why it waits, and when it is there. */
export function TransportStory() {
  const id = shownTransport.value;
  const { again, answer, failed } = useRefreshed(async () => {
    const wanted = shownTransport.value;
    const [transport, story] = await Promise.all([fetchTransport(wanted), fetchTransportStory(wanted)]);
    return { transport, story };
  }, AGAIN_MS);
  const found = answer.value?.transport.id === id ? answer.value : null;
  return (
    <StoryFrame
      id={id}
      failed={failed.value === null ? null : t("called.page.failed", { reason: failed.value })}
      loading={t("view.loading")}
      back={{ href: "#transports", text: t("called.page.all") }}
    >
      {found && (
        <>
          <Head transport={found.transport} story={found.story} onChanged={again} />
          <div class="order-columns">
            <div class="order-main">
              <LanesCard transport={found.transport} story={found.story} />
              <Moments moments={found.story.moments} partly={found.story.is_whole ? "" : t("called.page.partly")} />
            </div>
            <div class="order-side">
              <Waits transport={found.transport} />
              <LinkCard
                key={id}
                title={t("called.links.title")}
                links={found.story.links}
                hint={t("called.links.hint")}
                sure={t("called.links.sure")}
                make={() => makeTransportLink(id)}
                revoke={() => revokeTransportLinks(id)}
                onChanged={again}
              />
            </div>
          </div>
        </>
      )}
    </StoryFrame>
  );
}

interface Props {
  transport: TransportAnswer;
  story: Story;
}

/** Answers first what people come for: where it is, and when it is there. */
function Head({ onChanged, story, transport }: Props & { onChanged: () => void }) {
  const { called_by, cancel_at, due_at, ended_at, from, id, item, priority, quantity, status, task, thing, to } = transport;
  const { before, last } = carriersOf(story);
  const isLive = task !== null && world.value?.tasks.has(task) === true;
  return (
    <section class="card order-head" aria-labelledby="transport-title">
      <div class="order-title">
        <p class="muted">
          <a class="quiet-link" href="#transports">
            {t("called.title")}
          </a>
          {` / ${id}`}
        </p>
        <h1 id="transport-title">{t("called.page.what", { load: thing ?? loadOf(item, quantity), from: placeOf(from), to: placeOf(to) })}</h1>
        <Tag tone={status === "cancelled" ? "warn" : "normal"}>
          {cancel_at !== null && ended_at === null ? t("called.beingOff") : word("called.is", status)}
        </Tag>
        {priority !== "normal" && <Tag tone={priority === "urgent" ? "warn" : "normal"}>{word("priority", priority)}</Tag>}
        <div class="order-deeds">
          {isLive && (
            <button type="button" class="button small" onClick={() => { choose({ kind: "task", id: task }); go("plant"); }}>
              {t("orderPage.show")}
            </button>
          )}
          <button type="button" class="button small" onClick={() => void printPage()}>
            {ofOrders("orderPage.print")}
          </button>
          {canCallOff(transport) && <CallOff key={id} transport={id} onDone={onChanged} />}
        </div>
      </div>
      <dl class="order-figures">
        <Figure head={t("called.at")} more={called_by}>{when(secondsOf(transport.created_at))}</Figure>
        <Steps {...stepsOf(story)} />
        <Figure head={t("called.due")} more={hasEnded(transport) ? "" : dueText(secondsOf(due_at) ?? 0)}>
          {when(secondsOf(due_at))}
          {lateS(transport, nowS.value) > 0 && <Tag tone="warn">{t("orders.late")}</Tag>}
        </Figure>
        <Arrival transport={transport} />
        <Figure head={t("called.page.carrier")} more={before.length === 0 ? "" : t("called.page.before", { carriers: format.list(before) })}>
          {last === "" ? t("called.page.nobody") : last}
        </Figure>
      </dl>
    </section>
  );
}

/** When it was there, or is expected there; or when it was called off. */
function Arrival({ transport }: { transport: TransportAnswer }) {
  const { ended_at, status } = transport;
  if (ended_at !== null) {
    return <Figure head={status === "delivered" ? ofOrders("orderPage.deliveredAt") : t("called.page.ended")}>{when(secondsOf(ended_at))}</Figure>;
  }
  const atS = expectedS(transport);
  const isLate = atS !== null && lateS(transport, nowS.value) > 0;
  const more = atS === null ? ofOrders("orderPage.unknown") : ofOrders(isLate ? "orderPage.tooLate" : "orderPage.inTime");
  return (
    <Figure head={ofOrders("orderPage.expected")} more={more} warns={isLate}>
      {when(atS)}
    </Figure>
  );
}

function when(atS: number | null): string {
  return atS === null ? "–" : format.due(atS, nowS.value);
}

function dueText(dueS: number): string {
  const leftS = dueS - nowS.value;
  return leftS >= 0 ? ofOrders("orderPage.dueIn", { time: format.duration(leftS) }) : ofOrders("orderPage.dueSince", { time: format.duration(-leftS) });
}

/** Calls it off, after a second thought. */
function CallOff({ onDone, transport }: { transport: string; onDone: () => void }) {
  const asking = useSignal(false);
  const busy = useSignal(false);
  const failed = useSignal("");
  const end = async (): Promise<void> => {
    busy.value = true;
    failed.value = "";
    try {
      await callOff(transport);
      onDone();
    } catch (error) {
      failed.value = t("called.failed", { reason: problemText(error) });
    } finally {
      busy.value = false;
      asking.value = false;
    }
  };
  return (
    <span class="order-actions">
      {asking.value ? (
        <Sure
          asked={t("called.sure", { id: transport })}
          no={t("called.keep")}
          yes={t("called.off")}
          busy={busy.value}
          onNo={() => (asking.value = false)}
          onYes={() => void end()}
        />
      ) : (
        <button type="button" class="button small" onClick={() => (asking.value = true)}>
          {t("called.off")}
        </button>
      )}
      {failed.value !== "" && (
        <span class="complaint" role="alert">
          {failed.value}
        </span>
      )}
    </span>
  );
}

function LanesCard({ story, transport }: Props) {
  const isClosed = hasEnded(transport);
  const untilS = secondsOf(transport.ended_at) ?? nowS.value;
  const attempts = attemptsOf(story, untilS);
  const atS = expectedS(transport);
  // One that was given out once is told without being asked for.
  const told = story.attempts.find(({ task }) => task === chosenTransport.value) ?? (story.attempts.length === 1 ? story.attempts[0] : undefined);
  return (
    <Card title={t("called.page.lanes")} class="order-lanes">
      {attempts.length === 0 && <p class="empty">{t("called.page.none")}</p>}
      {!story.is_whole && <p class="muted">{t("called.page.forgotten")}</p>}
      {attempts.length > 0 && (
        <>
          <TransportLanes
            attempts={attempts}
            span={spanOf(transport, story, untilS)}
            nowS={isClosed ? Infinity : nowS.value}
            dueS={shownDueS(transport)}
            expected={atS === null ? null : { from_at_s: atS, to_at_s: atS }}
          />
          <Legend kinds={["fetch", "carry", "lost", ...(atS === null ? [] : ["expected" as const]), ...(isClosed ? [] : ["now" as const]), ...(shownDueS(transport) === null ? [] : ["due" as const])]} />
        </>
      )}
      {told && <Told transport={told} />}
    </Card>
  );
}

/** Why it is not there yet, by name: what it lacks, why a wished vehicle does not come, and for whom its carrier stands. */
function Waits({ transport }: { transport: TransportAnswer }) {
  const { ability, carrier, ended_at, from: source, not_before, refused, shortage, task: name, vehicle, vehicle_until, vehicle_waits, wait } = transport;
  const task = name === null ? undefined : world.value?.tasks.get(name);
  const stands = carrier === null ? undefined : world.value?.waits.get(carrier);
  const lines = [
    wait === null || wait === "not_before" ? "" : word("calling.wait", wait),
    refused === null ? "" : word("called.refused", refused),
    vehicle === null || vehicle_waits === null ? "" : t("called.wantedIs", { vehicle, why: word("unwilling", vehicle_waits) }),
    task?.trouble == null ? "" : causeText(task.trouble),
  ].filter((line) => line !== "");
  const more = [
    shortageText(source, shortage),
    wait === "not_before" ? t("called.begins", { at: when(secondsOf(not_before)) }) : "",
    vehicle_until === null || ended_at !== null ? "" : t("called.until", { at: when(secondsOf(vehicle_until)) }),
    ability === null ? "" : t("called.asks", { ability }),
    task && isOpen(task) ? whyText(task) : "",
  ].filter((line) => line !== "");
  if (lines.length === 0 && more.length === 0 && !stands) return null;
  const isHeld = lines.length > 0 || stands !== undefined;
  return (
    <Card title={isHeld ? ofOrders("orderPage.waits") : t("called.vehicle")} class={isHeld ? "order-waits" : ""}>
      {lines.map((line) => (
        <p key={line} class="tone-warn">{line}</p>
      ))}
      {task && <LoadSeen key={task.id} task={task} />}
      {stands && <WaitNote wait={stands} />}
      {more.map((line) => (
        <p key={line} class="muted">{line}</p>
      ))}
    </Card>
  );
}
