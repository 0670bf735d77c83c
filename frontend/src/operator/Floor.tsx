import { useComputed, useSignal, useSignalEffect } from "@preact/signals";
import type { RefObject } from "preact";
import { useEffect, useRef } from "preact/hooks";
import { selection } from "../selection/selection";
import { world } from "../stream/stream";
import { t } from "../text/operator";
import { AreaMap } from "./area/AreaMap";
import { Cards } from "./cards/Cards";
import { groupsOf, type Groups, shownGroups } from "./cards/need";
import { StopDock } from "./cards/StopDock";
import { watchTouch } from "./cards/touch";
import { moment, placeName, plant, plantFailed } from "./state";
import { StationCard } from "./station/StationCard";

/**
 * Who needs somebody, then the place, then who is well: one page that scrolls. As soon as it does, every
 * Stop is below it, too.
 */
export function Floor() {
  const page = useRef<HTMLElement>(null);
  const foot = useRef<HTMLElement>(null);
  const held = useSignal(false);
  const groups = useSignal<Groups>({ needing: [], well: [] });
  const wanted = useComputed(() => groupsOf(world.value?.atvs.values() ?? [], moment.value));
  const scrolls = useScrolls(page, foot);

  useSignalEffect(() => {
    groups.value = shownGroups(groups.peek(), wanted.value, held.value);
  });
  useEffect(() => {
    if (!page.current) return undefined;
    return watchTouch(page.current, (yes) => {
      held.value = yes;
    });
  }, [held]);
  useSignalEffect(() => {
    const chosen = selection.value.atv;
    if (chosen !== null) document.getElementById(`vehicle-${chosen}`)?.scrollIntoView({ block: "nearest" });
  });

  const { needing, well } = groups.value;
  const name = placeName.value;
  return (
    <>
      <main ref={page} id="vehicles" tabIndex={-1}>
        <Cards class="needing" ids={needing} label={t("cards.needing")} />
        <Place />
        <Cards class="well" ids={well} label={t("cards.well", { name })} />
        {needing.length + well.length === 0 && <p class="empty">{t(world.value ? "cards.none" : "loading")}</p>}
      </main>
      <footer ref={foot}>
        {scrolls && <StopDock ids={[...needing, ...well]} />}
        <p id="stop-not">
          <b>{t("stop.label")}</b> {t("stop.not")}
        </p>
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

/** Whether the page is longer than its room; with what is at its foot now, or was when that was least. */
function useScrolls(page: RefObject<HTMLElement | null>, foot: RefObject<HTMLElement | null>): boolean {
  const scrolls = useSignal(false);
  useEffect(() => {
    const inside = page.current;
    if (!inside) return undefined;
    let leastFootPx = Infinity;
    const look = (): void => {
      const footPx = foot.current?.clientHeight ?? 0;
      leastFootPx = Math.min(leastFootPx, footPx);
      // Else the dock would make the room for its own absence.
      scrolls.value = inside.scrollHeight > inside.clientHeight + footPx - leastFootPx;
    };
    const sizes = new ResizeObserver(look);
    sizes.observe(inside);
    const cards = new MutationObserver(look);
    cards.observe(inside, { childList: true, subtree: true, characterData: true });
    look();
    return () => {
      sizes.disconnect();
      cards.disconnect();
    };
  }, [foot, page, scrolls]);
  return scrolls.value;
}
