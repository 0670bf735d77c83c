import { fetchOrder, fetchTimeline, makeLink, revokeLinks } from "../../../api/client";
import type { OrderAnswer, OrderView } from "../../../api/types";
import { Card } from "../../../parts/Card";
import "../../../parts/paper.css";
import { choose } from "../../../selection/selection";
import { nowS, world } from "../../../stream/stream";
import { speakAlso } from "../../../text/speech";
import { t, tables } from "../../../text/views/order";
import { useRefreshed } from "../../refreshed";
import { go, shownOrder } from "../../views";
import { isClosed } from "../progress";
import { WaitsText } from "../WaitsText";
import { chosenTransport } from "./address";
import { ChangeCard } from "./ChangeCard";
import { EstimatesCard } from "./EstimatesCard";
import { Head } from "./Head";
import { Lanes } from "./Lanes";
import { dueOnAxis, groupsOf, legendOf, spanOf, type Story, type Transport } from "./lanes";
import { LinkCard } from "./LinkCard";
import { Moments } from "./Moments";
import { transportText } from "./moments";
import { StoryFrame } from "./StoryFrame";

/** A page of one order is looked at for minutes; its timeline is read from history. */
const AGAIN_MS = 3000;

/** The page, once it has its words. */
export async function load(): Promise<typeof OrderStory> {
  await speakAlso(tables);
  return OrderStory;
}

/** The order that the address names: what was made of it, who carried it, and what is still to come. */
export function OrderStory() {
  const id = shownOrder.value;
  const { again, answer, failed } = useRefreshed(async () => {
    const order = shownOrder.value;
    const [kept, story] = await Promise.all([fetchOrder(order), fetchTimeline(order)]);
    return { kept, story };
  }, AGAIN_MS);
  const found = answer.value?.kept.id === id ? answer.value : null;
  return (
    <StoryFrame
      id={id}
      failed={failed.value === null ? null : t("orderPage.failed", { reason: failed.value })}
      loading={t("view.loading")}
      back={{ href: "#orders", text: t("orderPage.all") }}
    >
      {found && <Page kept={found.kept} story={found.story} again={again} />}
    </StoryFrame>
  );
}

function Page({ again, kept, story }: { kept: OrderAnswer; story: Story; again: () => void }) {
  const { id } = kept;
  const order: OrderView = world.value?.orders.get(id) ?? kept;
  return (
    <>
      <Head order={order} story={story} />
      <div class="order-columns">
        <div class="order-main">
          <LanesCard order={order} story={story} />
          <Moments moments={story.moments} partly={story.is_whole ? "" : t("moments.partly")} />
        </div>
        <div class="order-side">
          {order.waits !== null && (
            <Card title={t("orderPage.waits")} class="order-waits">
              <WaitsText waits={order.waits} />
            </Card>
          )}
          {/* What can be done comes before what was: its buttons are in sight on a laptop. */}
          <ChangeCard key={`change ${id}`} kept={kept} onChanged={again} />
          <EstimatesCard
            key={`estimates ${id}`}
            estimates={story.estimates}
            expected={isClosed(order) ? null : story.expected}
            dueS={order.due_at_s}
            deliveredS={order.delivered_at_s}
            untilS={isClosed(order) ? endOf(order, story) : nowS.value}
            hasEnded={isClosed(order)}
          />
          <LinkCard
            key={id}
            title={t("links.title")}
            links={story.links}
            hint={t("links.hint")}
            sure={t("links.revokeSure")}
            make={() => makeLink(id)}
            revoke={() => revokeLinks(id)}
            onChanged={again}
          />
        </div>
      </div>
    </>
  );
}

/** When an order that has ended did so, as far as that is known. */
function endOf(order: OrderView, story: Story): number {
  return order.delivered_at_s ?? story.moments.at(-1)?.at_s ?? order.created_at_s;
}

function LanesCard({ order, story }: { order: OrderView; story: Story }) {
  const endedS = isClosed(order) ? endOf(order, story) : null;
  const untilS = endedS ?? nowS.value;
  const groups = groupsOf(story, untilS, endedS !== null);
  const dueS = dueOnAxis(order.due_at_s, endedS);
  const expected = endedS === null ? story.expected : null;
  const span = spanOf(groups, [untilS, dueS, expected?.to_at_s ?? null], order.created_at_s, endedS !== null);
  const drawn = legendOf(endedS !== null, dueS !== null, expected !== null);
  const transport = story.transports.find((each) => each.task === chosenTransport.value);
  return (
    <Card title={t("lanes.title")} class="order-lanes">
      {groups.length === 0 ? (
        <p class="empty">{t("lanes.none")}</p>
      ) : (
        <Lanes groups={groups} span={span} nowS={endedS === null ? nowS.value : Infinity} dueS={dueS} expected={expected} />
      )}
      {groups.length > 0 && <Legend kinds={drawn} />}
      {transport && <Told transport={transport} />}
      {!transport && chosenTransport.value !== "" && <p class="muted" role="status">{t("lanes.unknown")}</p>}
    </Card>
  );
}

/** What the bars and lines of the lanes mean. */
export function Legend({ kinds }: { kinds: ReturnType<typeof legendOf> }) {
  return (
    <p class="lane-legend" aria-hidden="true">
      {kinds.map((kind) => (
        <span key={kind}>
          <i class={kind === "now" || kind === "due" ? `lane-${kind}` : `lane-bar lane-${kind}`} /> {t(`lanes.legend.${kind}`)}
        </span>
      ))}
    </p>
  );
}

/** The chosen transport, in words. */
export function Told({ transport }: { transport: Transport }) {
  const carrier = transport.legs.at(-1)?.carrier ?? "";
  return (
    <div class="order-told" role="status">
      <p>{transportText(transport, nowS.value)}</p>
      {world.value?.atvs.has(carrier) === true && (
        <button
          type="button"
          class="button small"
          onClick={() => {
            choose({ kind: "atv", id: carrier });
            go("plant");
          }}
        >
          {t("lanes.onMap", { carrier })}
        </button>
      )}
    </div>
  );
}
