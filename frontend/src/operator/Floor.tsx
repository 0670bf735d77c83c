import { batch, useComputed, useSignal, useSignalEffect } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { selection } from "../selection/selection";
import { tickMs, world } from "../stream/stream";
import { format, t } from "../text/operator";
import { AreaMap } from "./area/AreaMap";
import { CallCard } from "./call/CallCard";
import { Cards } from "./cards/Cards";
import { AskingCalls, TakenCalls } from "./duty/CallCards";
import { DutyCard } from "./duty/DutyCard";
import { forms } from "./cards/forms";
import { groupsOf, type Groups, movedCards, shownGroups } from "./cards/need";
import { settle } from "./cards/settling";
import { type Left, stayed } from "./cards/staying";
import { refuseTooSoon, watchTouch } from "./cards/touch";
import { DoubtCards } from "./goods/DoubtCards";
import { doubtsOf } from "./goods/doubts";
import { GoodsCards } from "./goods/GoodsCards";
import { heldOf } from "./goods/held";
import { HeldCards } from "./goods/HeldCards";
import { strandedOf } from "./goods/stranded";
import { GateCard, needingGate } from "./machines/GateCard";
import { MachineCards } from "./machines/MachineCards";
import { needsSomebody } from "./machines/need";
import { moment, placeName, plant, plantFailed } from "./state";
import { StationCard } from "./station/StationCard";
import { StopBar } from "./stop/StopBar";
import { WordsCard } from "./words/WordsCard";
import { Unconfirmed } from "./stop/Unconfirmed";

/** Who needs somebody, then the place, then who is well: one page that scrolls. Who asks this person is above it, every Stop below it, always. */
export function Floor() {
  const page = useRef<HTMLElement>(null);
  const held = useSignal(false);
  const groups = useSignal<Groups>({ needing: [], well: [] });
  const wanted = useComputed(() => groupsOf(world.value?.atvs.values() ?? [], moment.value));

  const all = useSignal<ReadonlyMap<string, Left>>(new Map());
  const tooSoon = useSignal<string | null>(null);

  // In one effect: nothing is drawn between one of them and the next.
  useSignalEffect(() => {
    if (world.value === null) return;
    const open = new Set(forms.value.keys());
    const present = stayed(all.peek(), world.value.atvs, open, Math.max(tickMs.value, performance.now()));
    const staying = new Set([...present].filter(([, { atMs }]) => atMs !== null).map(([id]) => id));
    const before = groups.peek();
    const after = shownGroups(before, wanted.value, held.value, staying);
    const moved = before.needing.length + before.well.length === 0 ? [] : movedCards(before, after);
    batch(() => {
      settle(moved);
      all.value = present;
      groups.value = after;
    });
  });
  useEffect(() => {
    if (!page.current) return undefined;
    const stops = [
      watchTouch(page.current, (yes) => {
        held.value = yes;
      }),
      refuseTooSoon(page.current, (id) => {
        tooSoon.value = id;
      }),
    ];
    return () => {
      for (const stop of stops) stop();
    };
  }, [held, tooSoon]);
  useSignalEffect(() => {
    const chosen = selection.value.atv;
    if (chosen !== null) document.getElementById(`vehicle-${chosen}`)?.scrollIntoView({ block: "nearest" });
  });

  const { needing, well } = groups.value;
  const name = placeName.value;
  const goods = strandedOf(world.value?.tasks.values() ?? []).length;
  const disputed = heldOf(world.value?.tasks.values() ?? []).length;
  const doubtful = world.value === null ? 0 : doubtsOf(world.value).length;
  const gate = needingGate(world.value?.stations, moment.value) === null ? 0 : 1;
  const count = needing.length + goods + disputed + doubtful + gate + needsSomebody(world.value?.machines.values() ?? [], moment.value);
  return (
    <>
      <AskingCalls />
      <main ref={page} id="vehicles" tabIndex={-1}>
        <TakenCalls />
        {count > 0 && (
          <p class="needing-head">
            <b>{t("cards.needingCount", { count: format.count(count) })}</b> <span class="muted">{t("cards.joinBelow")}</span>
          </p>
        )}
        <Cards class="needing" ids={needing} all={all.value} tooSoon={tooSoon.value} label={t("cards.needing")} />
        <GoodsCards />
        <HeldCards />
        <DoubtCards />
        <MachineCards />
        <GateCard />
        <WordsCard />
        <Place />
        <Cards class="well" ids={well} all={all.value} tooSoon={tooSoon.value} label={t("cards.well", { name })} />
        {needing.length + well.length === 0 && <p class="empty">{t(world.value ? "cards.none" : "loading")}</p>}
        <CallCard />
        <DutyCard />
      </main>
      <footer id="stops" tabIndex={-1}>
        <Unconfirmed />
        <StopBar />
        <p id="stop-not">
          <b>{t("stop.label")}</b> {t("stop.not")}
        </p>
        <p class="muted stop-places">{t("stop.places")}</p>
      </footer>
    </>
  );
}

function Place() {
  return (
    <div class="place">
      {plant.value ? (
        <AreaMap plant={plant.value} />
      ) : (
        <section class="map card map-waiting">
          {plantFailed.value === null ? t("loading") : t("failed", { reason: plantFailed.value })}
        </section>
      )}
      <StationCard />
    </div>
  );
}
