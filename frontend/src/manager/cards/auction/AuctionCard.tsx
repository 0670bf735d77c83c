import { effect, signal, useComputed } from "@preact/signals";
import type { TaskView } from "../../../api/types";
import { Card } from "../../../parts/Card";
import { Tag } from "../../../parts/Tag";
import { selection } from "../../../selection/selection";
import { world } from "../../../stream/stream";
import { isHeld } from "../../../parts/held-task";
import { causeText } from "../../../text/failure";
import { format, n, t, word } from "../../../text/manager";
import { names, placeOf, taskName } from "../../state";
import { Term } from "../../story/Term";
import { storyOf } from "../../views";
import { auctionOf, isWon, shownTask } from "./auction";
import { BidLine } from "./BidLine";
import { Carriers } from "./Carriers";
import { LoadSeen } from "./LoadSeen";
import { RefusalLine } from "./RefusalLine";
import { taskTimes } from "./times";
import { WatchBids } from "./WatchBids";
import { whyText } from "./why-text";

const follow = signal<"chosen" | "newest">("chosen");
/** What was chosen when somebody asked for the newest. */
let unlike = selection.peek();
// Whatever is chosen is shown: who asks for the newest asks until then.
effect(() => {
  if (selection.value !== unlike) follow.value = "chosen";
});

/** The height of the card is fixed, so that the map above it never moves: rows and the sentence share it. */
const SHARED_PX = 145;
const ROW_PX = 28;
const LINE_PX = 18;
/** In one line of the sentence, on the smallest screen. */
const LINE_CHARS = 85;

function rowsBeside(why: string): number {
  return Math.floor((SHARED_PX - LINE_PX * Math.ceil(why.length / LINE_CHARS)) / ROW_PX);
}

/** Bottom middle: who bid, who refused, and why this vehicle. */
export function AuctionCard() {
  const task = useComputed(() =>
    world.value ? shownTask(world.value, selection.value, follow.value) : null,
  ).value;
  return (
    <Card title={<Title task={task} />} aside={<Aside task={task} />} class="auction">
      {task ? <Bids task={task} /> : <p class="empty">{t(noneKey())}</p>}
    </Card>
  );
}

function noneKey() {
  return follow.value === "chosen" && selection.value.latest !== null ? "auction.noneOfChosen" : "auction.none";
}

function Title({ task }: { task: TaskView | null }) {
  if (!task) return <>{t("auction.title")}</>;
  const what = t("auction.what", { quantity: format.count(task.quantity), item: names.value(task.item) });
  const source = task.source ? placeOf(task.source) : task.sources.map(placeOf).join(" / ");
  const page = storyOf(task);
  const name = taskName(task.id, task.order);
  return (
    <>
      {t("auction.title")}{" "}
      {page === "" ? name : <a class="link" href={page}>{name}</a>}
      <span class="title-more">
        {what}
        {task.destination && `, ${t("auction.way", { source, destination: placeOf(task.destination) })}`}
      </span>
    </>
  );
}

function Aside({ task }: { task: TaskView | null }) {
  return (
    <>
      {task && task.round > 1 && <Tag><Term name="round">{t("auction.round", { round: task.round })}</Term></Tag>}
      {task && task.epoch > 1 && <Tag><Term name="epoch">{t("auction.epoch", { epoch: task.epoch })}</Term></Tag>}
      {task && <Tag>{word("state", task.state)}</Tag>}
      <div class="segments" role="group" aria-label={t("auction.follow")}>
        {(["chosen", "newest"] as const).map((each) => (
          <button
            key={each}
            type="button"
            aria-pressed={follow.value === each}
            onClick={() => {
              unlike = selection.peek();
              follow.value = each;
            }}
          >
            {t(each === "chosen" ? "auction.ofChosen" : "auction.newest")}
          </button>
        ))}
      </div>
    </>
  );
}

function Bids({ task }: { task: TaskView }) {
  const { mostS, parts, refusals, rows, watch } = auctionOf(task);
  const why = whyText(task);
  const held = isHeld(task);
  const room = rowsBeside(why) - Number(task.carriers.length > 1) - Number(task.trouble !== null) - Number(held) - Number(watch.length > 0);
  // What somebody is asked has the room of a bid.
  const bids = rows.slice(0, Math.max(held ? 1 : 2, room - Math.min(1, refusals.length)));
  const refused = refusals.slice(0, Math.max(0, room - bids.length));
  const moreBids = rows.length - bids.length;
  const moreRefusals = refusals.length - refused.length;
  return (
    <>
      <p class="why" tabIndex={0}>
        {why}
        {task.trouble !== null && <span class="tone-warn"> {t("why.trouble", { reason: causeText(task.trouble) })}</span>}
      </p>
      <LoadSeen key={task.id} task={task} />
      <ul class="bids">
        {bids.map((row) => (
          <BidLine key={row.bid.bidder} row={row} parts={parts} mostS={mostS} won={isWon(task)} />
        ))}
        {refused.map((refusal) => (
          <RefusalLine key={refusal.agent} refusal={refusal} />
        ))}
      </ul>
      {watch.length > 0 && <WatchBids rows={watch} />}
      {task.carriers.length > 1 && <Carriers carriers={task.carriers} />}
      <footer class="bids-foot">
        <span class="legend">
          {parts.map((part) => (
            <span key={part}>
              <i class={`swatch part-${part}`} aria-hidden="true" />
              {part === "suitability" ? <Term name="suitability">{word("part", part)}</Term> : word("part", part)}
            </span>
          ))}
        </span>
        <span class="faint">
          {[
            ...(moreBids > 0 ? [n("auction.moreBids", moreBids)] : []),
            ...(moreRefusals > 0 ? [n("auction.moreRefusals", moreRefusals)] : []),
            ...taskTimes(task, world.value?.factory.speed ?? 1),
          ].join(" · ")}
        </span>
      </footer>
    </>
  );
}
