import { useSignal, useSignalEffect } from "@preact/signals";
import type { RefObject } from "preact";
import { useEffect, useRef } from "preact/hooks";
import { Icon } from "../../parts/Icon";
import { selection } from "../../selection/selection";
import { n, t } from "../../text/operator";
import { moved, places, seat } from "./seats";
import { StopTile } from "./StopTile";

/**
 * Stop for every vehicle near: one line at the foot of the page that scrolls, so that it hides nothing however
 * many there are. Every vehicle keeps its place in it.
 */
export function StopBar() {
  const line = useRef<HTMLDivElement>(null);
  const beyond = useBeyond(line);
  useSignalEffect(seat);
  useSignalEffect(() => {
    const chosen = selection.value.atv;
    if (chosen !== null) show(document.getElementById(`stop-${chosen}`));
  });
  const turnTo = (to: -1 | 1) => () => {
    turn(line.current, to);
  };
  if (places.value.length === 0) return null;
  return (
    <div class="bar">
      <div ref={line} class="dock" role="group" aria-label={t("stop.dock")}>
        {places.value.map((place) => (
          <StopTile key={place.atv} place={place} />
        ))}
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
function useBeyond(line: RefObject<HTMLElement | null>): { before: number; after: number } {
  const beyond = useSignal({ before: 0, after: 0 });
  const count = places.value.length;
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
    let widthPx = inside.clientWidth;
    const sizes = new ResizeObserver(() => {
      // Turned, or enlarged.
      if (inside.clientWidth !== widthPx) moved();
      widthPx = inside.clientWidth;
      look();
    });
    sizes.observe(inside);
    inside.addEventListener("scroll", look, { passive: true });
    look();
    return () => {
      sizes.disconnect();
      inside.removeEventListener("scroll", look);
    };
  }, [beyond, count, line]);
  return beyond.value;
}
