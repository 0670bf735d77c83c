import { useSignal, useSignalEffect } from "@preact/signals";
import type { RefObject } from "preact";
import { useEffect, useRef } from "preact/hooks";
import { Icon } from "../../parts/Icon";
import { selection } from "../../selection/selection";
import { n, t } from "../../text/operator";
import type { Place } from "./places";
import { inSight, moved, places, seat } from "./seats";
import { StopTile } from "./StopTile";

/** A page of less height keeps one line of Stops, and the rest of it for what they are about. */
const LOW = "(max-height: 560px)";

/**
 * Stop for every vehicle near, at the foot of the page: two lines, of which the second scrolls where more are near than
 * they hold. Every vehicle keeps its place.
 */
export function StopBar() {
  const bar = useRef<HTMLDivElement>(null);
  const all = places.value;
  const columns = useColumns(bar, all.length === 0);
  useSignalEffect(seat);
  useSignalEffect(() => {
    const chosen = selection.value.atv;
    if (chosen !== null) show(document.getElementById(`stop-${chosen}`));
  });
  if (all.length === 0) return null;
  const first = columns === null || all.length <= columns ? [] : all.slice(0, columns);
  return (
    <div ref={bar} class={first.length > 0 ? "bar two" : "bar"} role="group" aria-label={t("stop.dock")}>
      {first.length > 0 && (
        <div class="dock">
          <Tiles places={first} />
        </div>
      )}
      <ScrollingLine places={all.slice(first.length)} />
    </div>
  );
}

function Tiles({ places }: { places: readonly Place[] }) {
  return places.map((place) =>
    place.state === "free" ? <span key={place.atv} class="stop-free" /> : <StopTile key={place.atv} place={place} />,
  );
}

function ScrollingLine({ places }: { places: readonly Place[] }) {
  const line = useRef<HTMLDivElement>(null);
  const beyond = useBeyond(line, places.length);
  const turnTo = (to: -1 | 1) => () => {
    turn(line.current, to);
  };
  return (
    <div class="line">
      <div ref={line} class="dock">
        <Tiles places={places} />
      </div>
      {(beyond.before > 0 || beyond.after > 0) && (
        <div class="turns">
          <Turn name="left" count={beyond.before} onTurn={turnTo(-1)} />
          <Turn name="right" count={beyond.after} onTurn={turnTo(1)} />
        </div>
      )}
    </div>
  );
}

/** How many places stand beside one another in the first of two lines; null where there is one line only. Says what is in sight. */
function useColumns(bar: RefObject<HTMLElement | null>, isEmpty: boolean): number | null {
  const columns = useSignal<number | null>(null);
  useEffect(() => {
    const inside = bar.current;
    if (!inside) return undefined;
    const low = matchMedia(LOW);
    const look = (): void => {
      const style = getComputedStyle(inside);
      const gapPx = parseFloat(style.columnGap);
      const fit = Math.max(1, Math.floor((inside.clientWidth + gapPx) / (parseFloat(style.getPropertyValue("--thumb")) + gapPx)));
      const shown = low.matches ? fit : 2 * fit;
      columns.value = low.matches ? null : fit;
      // Turned, or enlarged.
      if (inSight.peek() !== Infinity && inSight.peek() !== shown) moved();
      inSight.value = shown;
    };
    const sizes = new ResizeObserver(look);
    sizes.observe(inside);
    low.addEventListener("change", look);
    look();
    return () => {
      sizes.disconnect();
      low.removeEventListener("change", look);
    };
  }, [bar, columns, isEmpty]);
  return columns.value;
}

function Turn({ count, name, onTurn }: { name: "left" | "right"; count: number; onTurn: () => void }) {
  return (
    <button type="button" class="button turn" disabled={count === 0} onClick={onTurn}>
      <Icon name={name} />
      <small>{count === 0 ? "" : n("stop.more", count)}</small>
      <span class="unseen">{t(name === "left" ? "stop.before" : "stop.after")}</span>
    </button>
  );
}

/** As far as can be seen at once, but for one, so that a person knows where the line goes on. */
function turn(line: HTMLElement | null, to: -1 | 1): void {
  if (!line) return;
  const pitchPx = pitchOf(line);
  line.scrollLeft += to * Math.max(1, Math.floor(line.clientWidth / pitchPx) - 1) * pitchPx;
  moved();
}

function show(tile: HTMLElement | null): void {
  const line = tile?.parentElement;
  if (!tile || !line) return;
  const beforePx = line.scrollLeft;
  tile.scrollIntoView({ block: "nearest", inline: "nearest" });
  if (line.scrollLeft !== beforePx) moved();
}

/** From one tile to the next. */
function pitchOf(line: HTMLElement): number {
  const [first, second] = line.children as unknown as [HTMLElement | undefined, HTMLElement | undefined];
  return Math.max(1, second && first ? second.offsetLeft - first.offsetLeft : (first?.offsetWidth ?? 1));
}

/** What of a tile may be out of sight without being missed: the room around the line. */
const EDGE_PX = 12;

/** How many are out of sight, wholly or in part, on either side. */
function useBeyond(line: RefObject<HTMLElement | null>, places: number): { before: number; after: number } {
  const beyond = useSignal({ before: 0, after: 0 });
  useEffect(() => {
    const inside = line.current;
    if (!inside) return undefined;
    const look = (): void => {
      const pitchPx = pitchOf(inside);
      const count = (px: number): number => Math.ceil((px - EDGE_PX) / pitchPx);
      const before = count(inside.scrollLeft);
      const after = count(inside.scrollWidth - inside.clientWidth - inside.scrollLeft);
      const known = beyond.peek();
      if (known.before !== before || known.after !== after) beyond.value = { before, after };
    };
    const sizes = new ResizeObserver(look);
    sizes.observe(inside);
    inside.addEventListener("scroll", look, { passive: true });
    look();
    return () => {
      sizes.disconnect();
      inside.removeEventListener("scroll", look);
    };
  }, [beyond, line, places]);
  return beyond.value;
}
