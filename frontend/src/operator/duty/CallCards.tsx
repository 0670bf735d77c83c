import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import type { CallView } from "../../api/types";
import { Tag } from "../../parts/Tag";
import { THING } from "../../plant/names";
import { vehicleName } from "../../text/elsewhere";
import { failureText } from "../../text/failure";
import { format, t, word } from "../../text/operator";
import { factoryTime, inFactoryTime } from "../../text/plant-time";
import { world } from "../../stream/stream";
import { doubtText } from "../goods/DoubtCards";
import { doubtsOf } from "../goods/doubts";
import { goodsText } from "../goods/GoodsCards";
import { isHeld } from "../../parts/held-task";
import { heldText, lookText } from "../goods/HeldCards";
import { moment, station } from "../state";
import { distanceM } from "../area/region";
import { answer, callFailed, duty, missed } from "./duty";

/** How long it takes to walk over and put something right. */
const MINUTES = [2, 5, 10];

/** Calls for help that ask this person, above the page: wherever it has been scrolled to they are in sight, and cover nothing of it. */
export function AskingCalls() {
  const region = useRef<HTMLDivElement>(null);
  useEffect(() => (region.current ? keepInPlace(region.current) : undefined), []);
  const calls = duty.value?.calls.filter(({ part }) => part !== null && part !== "taken") ?? [];
  const said = missed.value === null ? callFailed.value : missedText(missed.value);
  return (
    <div ref={region} class="calls-live" aria-live="assertive">
      {(said !== "" || calls.length > 0) && (
        // Focusable itself: it scrolls, and in its first half second no button can have the focus.
        <section tabIndex={0} class="calls-asking" aria-label={t("call.title")}>
          {said !== "" && <p class="card call-failed">{said}</p>}
          <Calls calls={calls} />
        </section>
      )}
    </div>
  );
}

/** Calls that this person has taken. */
export function TakenCalls() {
  return <Calls calls={duty.value?.calls.filter(({ part }) => part === "taken") ?? []} />;
}

function Calls({ calls }: { calls: readonly CallView[] }) {
  if (calls.length === 0) return null;
  return (
    <ul class="cards" aria-label={t("call.title")}>
      {calls.map((call) => (
        <CallCard key={call.id} call={call} />
      ))}
    </ul>
  );
}

/**
 * What somebody has scrolled to stays where it is while calls come and go above it: a finger on its way there meets what it meant.
 *
 * @param region holds the calls, above the page
 * @returns how to stop that
 */
function keepInPlace(region: HTMLElement): () => void {
  let heightPx = region.offsetHeight;
  const sizes = new ResizeObserver(() => {
    const grownPx = region.offsetHeight - heightPx;
    heightPx += grownPx;
    const page = document.getElementById("vehicles");
    if (page !== null && page.scrollTop > 0) page.scrollTop += grownPx;
  });
  sizes.observe(region);
  return () => {
    sizes.disconnect();
  };
}

function missedText({ by, caller }: { by: string; caller: string }): string {
  return by === "" ? t("call.quicker", { caller }) : t("call.tooLate", { by, caller });
}

/** A card that comes lies over the page: a finger that is on its way there meant something else. */
const SETTLE_MS = 500;

function CallCard({ call }: { call: CallView }) {
  const isSettled = useSignal(false);
  useEffect(() => {
    const timer = window.setTimeout(() => {
      isSettled.value = true;
    }, SETTLE_MS);
    return () => {
      clearTimeout(timer);
    };
  }, [isSettled]);
  const { nowS, speed } = moment.value;
  const leftS = Math.max(0, ((call.until_at_s ?? nowS) - nowS) * speed);
  const mine = call.part === "taken";
  const others = call.asked.filter((code) => code !== duty.value?.code);
  return (
    <li class="card call">
      <header>
        <h2>{call.caller}</h2>
        <Tag tone="warn">{t(mine ? "call.expected" : "call.asks")}</Tag>
        <span class="call-left">
          <b>{factoryTime(leftS)}</b> {t(mine ? "call.promised" : "call.toAnswer")}
        </span>
      </header>
      <div class="call-said">
        <p class="call-wrong">{wrongText(call)}</p>
        <p>{call.place === "untold" ? untoldText(call) : whereText(call)}</p>
        {call.place === "last" && <p>{t("call.place.last")}</p>}
        {call.elsewhere && <p class="muted">{t("call.elsewhere")}</p>}
        {!mine && <p class="muted">{others.length === 0 ? t("call.alone") : t("call.others", { count: format.count(others.length) })}</p>}
        {!mine && <p class="muted call-note">{t("call.notAssigned")}</p>}
      </div>
      <div class="call-answers" role="group" aria-label={t("call.take", { caller: call.caller })}>
        {MINUTES.map((minutes) => (
          <button
            key={minutes}
            type="button"
            class={`button ${mine ? "" : "primary"}`}
            disabled={call.part === "taking" || !isSettled.value}
            onClick={() => void answer(call, { answer: "take", wait_s: minutes * 60 })}
          >
            <b>{t(mine ? "call.later" : "call.iTake")}</b> {inFactoryTime(t("call.within", { minutes }))}
          </button>
        ))}
        <button type="button" class="button" disabled={!isSettled.value} onClick={() => void answer(call, { answer: "decline" })}>
          {t(mine ? "call.giveBack" : "call.pass")}
        </button>
        <button type="button" class="button" disabled={!isSettled.value} onClick={() => void answer(call, { answer: "cannot" })}>
          {t("call.cannot")}
        </button>
      </div>
    </li>
  );
}

/** Where to go: the map of this tablet need not show it. */
function whereText({ area, ...place }: CallView): string {
  const metres = station.value === undefined ? "" : format.count(distanceM(station.value, place));
  if (area === "") return metres === "" ? "" : t("call.away", { metres });
  return metres === "" ? t("call.where", { area }) : t("call.whereAway", { area, metres });
}

/** It may be anywhere: how far its start in the plant file is says nothing. */
function untoldText({ area }: CallView): string {
  return area === "" ? t("call.place.untold") : t("call.place.untoldIn", { area });
}

/** What is wrong: with the caller, or that goods of its own wait on board of a vehicle. One that has never told its place says just that. */
function wrongText({ goods, place, problem, reason }: CallView) {
  if (goods !== "") {
    const doubt = world.value === null ? undefined : doubtsOf(world.value).find(({ load }) => load === goods);
    if (doubt !== undefined) return <b>{doubtText(doubt)}</b>;
    const task = world.value?.tasks.get(goods);
    if (task !== undefined && isHeld(task)) return <><b>{heldText(task)}</b> {lookText(task)}</>;
    return <b>{task?.stranded ? `${t(task.item === THING ? "goods.titleThing" : "goods.title", { atv: vehicleName(task.stranded.atv) })}: ${goodsText(task)}` : t("goods.called")}</b>;
  }
  return (
    <>
      {reason !== "" && <b>{failureText(reason)}. </b>}
      {place !== "untold" && word("help.kind", problem)}
    </>
  );
}
