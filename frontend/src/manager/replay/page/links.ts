/** Whom a spell leads to: whom somebody waited for, who had the transport before and after, at whose dock. Pure. */
import type { Spell } from "./strips";

export type LinkKind = "waitsFor" | "waitedFor" | "watches" | "takenFrom" | "takenBy" | "loadsAt" | "bringsTo" | "brings" | "fetches";

export interface SpellLink {
  readonly kind: LinkKind;
  readonly agent: string;
  /** The moment of it. */
  readonly atS: number;
}

/** A machine has a dock, and a jam an end: more is no list that somebody reads. */
const MOST = 8;

/**
 * @param spells of everybody, in any order
 * @param agents those who have strips
 */
export function linksOf(spell: Spell, spells: readonly Spell[], agents: ReadonlySet<string>): SpellLink[] {
  const found = [...ownLinks(spell), ...carriersOf(spell, spells), ...othersOf(spell, spells)];
  const seen = new Set<string>();
  return found
    .filter(({ agent, kind }) => {
      const name = `${kind} ${agent}`;
      if (agent === spell.agent || !agents.has(agent) || seen.has(name)) return false;
      seen.add(name);
      return true;
    })
    .slice(0, MOST);
}

/** What it says itself. */
function ownLinks({ destination, doing, from_at_s: fromS, other, source, until_at_s: untilS }: Spell): SpellLink[] {
  const links: SpellLink[] = [];
  if (doing === "waits") links.push({ kind: "waitsFor", agent: other, atS: fromS });
  if (doing === "idle") links.push({ kind: "watches", agent: other, atS: fromS });
  links.push({ kind: "loadsAt", agent: source, atS: doing === "fetches" ? untilS : fromS });
  links.push({ kind: "bringsTo", agent: destination, atS: untilS });
  return links;
}

/** Who had the same transport before, and who after. */
function carriersOf({ agent, from_at_s: fromS, task, until_at_s: untilS }: Spell, spells: readonly Spell[]): SpellLink[] {
  if (task === "") return [];
  const others = spells.filter((each) => each.task === task && each.agent !== agent);
  const before = newest(others.filter((each) => each.from_at_s < fromS));
  const after = oldest(others.filter((each) => each.from_at_s >= untilS));
  return [
    ...(before ? [{ kind: "takenFrom", agent: before.agent, atS: before.from_at_s } as const] : []),
    ...(after ? [{ kind: "takenBy", agent: after.agent, atS: after.from_at_s } as const] : []),
  ];
}

/** Who waited for it at that time, and who came to its dock. */
function othersOf({ agent, from_at_s: fromS, until_at_s: untilS }: Spell, spells: readonly Spell[]): SpellLink[] {
  const links: SpellLink[] = [];
  for (const each of spells) {
    const isThen = each.from_at_s < untilS && each.until_at_s > fromS;
    if (isThen && each.doing === "waits" && each.other === agent) links.push({ kind: "waitedFor", agent: each.agent, atS: Math.max(fromS, each.from_at_s) });
    if (isThen && each.doing === "carries" && each.destination === agent) links.push({ kind: "brings", agent: each.agent, atS: each.from_at_s });
    if (isThen && each.doing === "fetches" && each.source === agent) links.push({ kind: "fetches", agent: each.agent, atS: each.from_at_s });
  }
  return links;
}

function newest(spells: readonly Spell[]): Spell | undefined {
  return spells.reduce<Spell | undefined>((best, each) => (best && best.from_at_s >= each.from_at_s ? best : each), undefined);
}

function oldest(spells: readonly Spell[]): Spell | undefined {
  return spells.reduce<Spell | undefined>((best, each) => (best && best.from_at_s <= each.from_at_s ? best : each), undefined);
}

/** The spell before or after a moment's own; undefined where none is known. */
export function spellBeside(own: readonly Spell[], atS: number, direction: -1 | 1): Spell | undefined {
  if (direction === 1) return oldest(own.filter((each) => each.from_at_s > atS));
  const now = own.find((each) => each.from_at_s <= atS && atS < each.until_at_s);
  return newest(own.filter((each) => each.from_at_s < (now?.from_at_s ?? atS)));
}

/** Seconds that the strips show, from the shortest on: each about twice the one before. */
export const SPANS_S = [30, 60, 180, 360, 720, 1800, 3600, 7200, 14_400, 28_800] as const;

/** One step shorter or longer. */
export function zoomedSpan(spanS: number, direction: "in" | "out"): number {
  const shorter = SPANS_S.filter((each) => each < spanS).at(-1);
  const longer = SPANS_S.find((each) => each > spanS);
  return (direction === "in" ? shorter : longer) ?? spanS;
}
