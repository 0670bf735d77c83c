/** What right of way shows on the map: places that are held, who waits for whom, and jams. Pure. */
import type { AlertView, AtvView, WaitView } from "../../api/types";
import type { Place } from "../../motion/roads";
import type { Line } from "../draw/lines";

type Find = (id: string) => Place | undefined;

/** Whether vehicles tell of right of way at all. */
export function hasTraffic(atvs: Iterable<Pick<AtvView, "holds">>): boolean {
  for (const { holds } of atvs) if (holds.length > 0) return true;
  return false;
}

/** How many nodes of its way a vehicle may drive: up to the last one that it holds. */
export function heldAhead({ holds, way }: Pick<AtvView, "holds" | "way">): number {
  const held = new Set(holds);
  return way.findLastIndex((node) => held.has(node)) + 1;
}

/**
 * The floor that a vehicle holds, from what lies behind it to the end of what it may drive.
 *
 * @param ahead from where it is shown to the end of its held way
 */
export function heldLine({ holds, node, way }: Pick<AtvView, "holds" | "node" | "way">, ahead: readonly Place[], find: Find): Place[] {
  const onward = new Set(way);
  const behind = holds.filter((place) => place !== node && !onward.has(place));
  if (holds.includes(node)) behind.push(node);
  return [...behind.flatMap((place) => find(place) ?? []), ...ahead];
}

export interface WaitLine extends Line {
  readonly chosen: boolean;
}

/** A line from each vehicle to the one that it waits for; those of the chosen one's chain are chosen. */
export function waitLines(waits: Iterable<WaitView>, find: Find, chosen: string | null): WaitLine[] {
  const all = [...waits];
  const own = all.find(({ id }) => id === chosen);
  const chain = new Set(own ? [own.id, ...own.cause.chain] : []);
  return all.flatMap(({ cause, id }) => {
    const from = find(id);
    const to = find(cause.chain[0] ?? "");
    return from && to ? [{ from, to, chosen: chain.has(id) }] : [];
  });
}

export interface Jam {
  readonly alert: AlertView;
  /** Each of those in it, to the one that it waits for; one that is alone to itself. */
  readonly lines: readonly Line[];
  /** Since when the first one has waited. */
  readonly sinceAtS: number;
}

/** The jams that people are alerted to, as far as those in them are seen. */
export function jamsOf(alerts: Iterable<AlertView>, waits: ReadonlyMap<string, WaitView>, find: Find): Jam[] {
  return [...alerts].filter(({ kind }) => kind === "jam").flatMap((alert) => {
    const lines = alert.agents.flatMap((id) => {
      const from = find(id);
      const to = find(waits.get(id)?.cause.chain[0] ?? "") ?? from;
      return from && to ? [{ from, to }] : [];
    });
    const sinceAtS = Math.min(...alert.agents.map((id) => waits.get(id)?.since_at_s ?? alert.since_at_s));
    return lines.length === 0 ? [] : [{ alert, lines, sinceAtS }];
  });
}
