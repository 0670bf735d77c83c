/** Marks of takeovers on the map: from whom to whom, for as long as the eye needs to find it. */
import type { NewsView } from "../../api/types";

/** Long enough to look up from a card and still see it. */
const SHOWN_S = 7;
/** Three waves, then only the line stays until the end. */
const WAVE_S = 1.4;
const WAVES = 3;
const REACH_PX = 30;
/** As many as the gateway keeps news. */
const MOST = 50;

export interface Mark {
  /** The new carrier. */
  readonly to: string;
  /** The one that it replaces. */
  readonly from: string;
  readonly begunAtMs: number;
}

export interface Wave {
  /** Beyond the rim of the vehicle. */
  readonly px: number;
  readonly alpha: number;
}

export interface MarkLook {
  readonly wave: Wave | null;
  readonly lineAlpha: number;
}

/** How a mark looks at this age; null when it is over. Without motion there is one still ring. */
export function markLook(ageS: number, smooth: boolean): MarkLook | null {
  if (ageS < 0 || ageS >= SHOWN_S) return null;
  const lineAlpha = Math.min(1, (SHOWN_S - ageS) / 1);
  if (!smooth) return { wave: { px: REACH_PX / 3, alpha: lineAlpha }, lineAlpha };
  if (ageS >= WAVES * WAVE_S) return { wave: null, lineAlpha };
  const part = (ageS % WAVE_S) / WAVE_S;
  return { wave: { px: part * REACH_PX, alpha: 1 - part }, lineAlpha };
}

/** Marks that are shown, by the id of their news: a takeover that is confirmed later begins no second one. */
export class Marks {
  readonly #marks = new Map<string, Mark>();

  observe(news: readonly NewsView[], nowMs: number): void {
    for (const { agent, id, kind, other } of news) {
      if (kind === "took_over" && !this.#marks.has(id)) this.#marks.set(id, { to: agent, from: other, begunAtMs: nowMs });
      // Refused: there is nothing to show any more.
      if (kind !== "took_over") this.#marks.delete(id);
    }
    for (const id of [...this.#marks.keys()].slice(0, Math.max(0, this.#marks.size - MOST))) this.#marks.delete(id);
  }

  /** Those that are still shown. */
  shown(nowMs: number, smooth: boolean): (Mark & { readonly look: MarkLook })[] {
    return [...this.#marks.values()].flatMap((mark) => {
      const look = markLook((nowMs - mark.begunAtMs) / 1000, smooth);
      return look ? [{ ...mark, look }] : [];
    });
  }
}
