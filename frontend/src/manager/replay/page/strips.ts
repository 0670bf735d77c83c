/** What agents did, as bars in time. Pure. */
import type { components } from "../../../api/types";
import type { Range } from "./film";

export type Spell = components["schemas"]["Spell"];

export interface StripBar {
  readonly spell: Spell;
  /** Percent of the time that is shown. */
  readonly left: number;
  readonly width: number;
}

/** Of the width: a pixel of a large screen. */
const LEAST_PERCENT = 0.05;

export function barsOf(spells: readonly Spell[], { fromS, toS }: Range): StripBar[] {
  const percent = (atS: number): number => (Math.min(toS, Math.max(fromS, atS)) - fromS) / (toS - fromS) * 100;
  const bars: StripBar[] = [];
  let drawnTo = -LEAST_PERCENT;
  for (const spell of spells) {
    if (spell.until_at_s <= fromS || spell.from_at_s >= toS) continue;
    const left = percent(spell.from_at_s);
    const right = percent(spell.until_at_s);
    // Of many in one pixel one is drawn.
    if (right - left < LEAST_PERCENT && right - drawnTo < LEAST_PERCENT) continue;
    bars.push({ spell, left, width: right - left });
    drawnTo = right;
  }
  return bars;
}

export function doneNow(spells: readonly Spell[], atS: number): Spell | undefined {
  return spells.find((spell) => spell.from_at_s <= atS && atS < spell.until_at_s);
}

export function byAgent(spells: readonly Spell[]): Map<string, Spell[]> {
  const found = new Map<string, Spell[]>();
  for (const spell of spells) {
    const own = found.get(spell.agent);
    if (own) own.push(spell);
    else found.set(spell.agent, [spell]);
  }
  return found;
}
