/** What a vehicle needs of a person, and in which order people should look. Pure. */
import type { AtvView } from "../../api/types";
import { byId } from "../../plant/places";
import { isLost } from "../../plant/silence";

/** The most urgent first. */
export const NEEDS = [
  /** It has asked for help by itself, and nobody has promised any. */
  "help",
  /** Somebody is on the way to it. */
  "coming",
  /** It has a problem, and no task that waits. */
  "problem",
  /** Nothing is heard of it. */
  "lost",
  /** A person has stopped it, and has to let it go on. */
  "stopped",
  "working",
  /** A person has taken it out of service: nothing of it asks for anybody. */
  "out",
  "resting",
] as const;
export type Need = (typeof NEEDS)[number];

/** From here on a vehicle gets along without a person. */
const FIRST_WELL = NEEDS.indexOf("working");

/** Names of vehicles, in the order in which they are shown. */
export interface Groups {
  /** Those that a person has to do something about. */
  readonly needing: readonly string[];
  readonly well: readonly string[];
}

export interface Moment {
  readonly nowS: number;
  /** Factory seconds per real second. */
  readonly speed: number;
}

export function needOf(atv: AtvView, { nowS, speed }: Moment): Need {
  if (atv.out_of_service && !atv.task) return "out";
  if (isLost(atv, nowS, speed)) return "lost";
  // Its task may wait for a person then, too; but it is a person who has brought that about.
  if (atv.status === "stopped") return "stopped";
  if (atv.help) return atv.help.promised_by === "" ? "help" : "coming";
  if (atv.problem !== "") return "problem";
  return atv.task ? "working" : "resting";
}

/**
 * Who needs somebody most is first; those who wait, by when their patience ends. Who is well stands by name:
 * what it does changes every minute, and nothing is to be done about it.
 */
export function groupsOf(atvs: Iterable<AtvView>, moment: Moment): Groups {
  const sorted = [...atvs]
    .map((atv) => ({ atv, rank: NEEDS.indexOf(needOf(atv, moment)) }))
    .sort((a, b) => a.rank - b.rank || untilS(a.atv) - untilS(b.atv) || byId(a.atv, b.atv));
  const ids = (of: typeof sorted): string[] => of.map(({ atv }) => atv.id);
  return {
    needing: ids(sorted.filter(({ rank }) => rank < FIRST_WELL)),
    well: ids(sorted.filter(({ rank }) => rank >= FIRST_WELL).sort((a, b) => byId(a.atv, b.atv))),
  };
}

function untilS({ help }: AtvView): number {
  return help?.until_at_s ?? 0;
}

/**
 * The groups as they are shown. Every card keeps its place in its group, and new ones join below.
 * While a finger rests on a card none moves away from under it into the other group, either.
 *
 * @param staying those that have gone and keep their place: a moment for the hand that is on its way, or as long as a form is open
 */
export function shownGroups(before: Groups, wanted: Groups, held: boolean, staying: ReadonlySet<string> = new Set()): Groups {
  const shown = held
    ? kept(before, wanted, staying)
    : { needing: joined(before.needing, wanted.needing, staying), well: joined(before.well, wanted.well, staying) };
  return same(shown.needing, before.needing) && same(shown.well, before.well) ? before : shown;
}

/** Vehicles whose card is at another place than before, or has come where another one was. */
export function movedCards(before: Groups, after: Groups): string[] {
  const [was, is] = [before, after].map(({ needing, well }) => [...needing, BETWEEN, ...well]) as [string[], string[]];
  const first = is.findIndex((id, i) => id !== was[i]);
  // Where nothing was nobody has seen anything else.
  if (first < 0 || first >= was.length) return [];
  return is.slice(first).filter((id) => id !== BETWEEN);
}

/** What stands between the groups. */
const BETWEEN = "";

function joined(before: readonly string[], wanted: readonly string[], staying: ReadonlySet<string>): string[] {
  const [known, still] = [new Set(before), new Set(wanted)];
  return [...before.filter((id) => still.has(id) || staying.has(id)), ...wanted.filter((id) => !known.has(id))];
}

function kept(before: Groups, wanted: Groups, staying: ReadonlySet<string>): Groups {
  const present = new Set([...wanted.needing, ...wanted.well, ...staying]);
  const known = new Set([...before.needing, ...before.well]);
  return {
    needing: before.needing.filter((id) => present.has(id)),
    well: [...before.well.filter((id) => present.has(id)), ...[...present].filter((id) => !known.has(id))],
  };
}

function same(a: readonly string[], b: readonly string[]): boolean {
  return a.length === b.length && a.every((id, i) => id === b[i]);
}

/** Factory seconds until its patience ends; negative when it is over, null where nothing waits. */
export function patienceS(atv: Pick<AtvView, "help">, { nowS, speed }: Moment): number | null {
  return atv.help ? (atv.help.until_at_s - nowS) * speed : null;
}
