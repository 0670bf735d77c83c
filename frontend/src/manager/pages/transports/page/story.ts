/** What the page of one plain transport draws and says, from what the gateway tells of it. Pure. */
import type { TaskStory, TransportAnswer, TransportState, TransportStory } from "../../../../api/transports";
import { barsOfLeg, dueOnAxis, type Group, type Span, spanBetween } from "../../../orders/page/lanes";

export function secondsOf(moment: string | null): number | null {
  return moment === null ? null : Date.parse(moment) / 1000;
}

export function hasEnded({ ended_at }: TransportAnswer): boolean {
  return ended_at !== null;
}

/** How each time that it was given out is drawn. */
export function attemptsOf(story: Pick<TransportStory, "attempts">, untilS: number): Group["transports"] {
  return story.attempts.map((transport) => ({ transport, bars: transport.legs.flatMap((leg) => barsOfLeg(leg, untilS)) }));
}

/** When it is due, as far as the axis shows that. */
export function shownDueS(transport: TransportAnswer): number | null {
  return dueOnAxis(secondsOf(transport.due_at), secondsOf(transport.ended_at));
}

/** From the call to the last of what has happened, is expected or due. */
export function spanOf(transport: TransportAnswer, story: TransportStory, untilS: number): Span {
  const fromS = secondsOf(transport.created_at) ?? untilS;
  const ends = [untilS, ...story.moments.map((moment) => moment.at_s), shownDueS(transport), expectedS(transport)].filter((atS) => atS !== null);
  return spanBetween(fromS, ends, hasEnded(transport));
}

/** How far a task is that is carried, in the words of a plain transport. */
export function stateOf({ attempts, transport: { state } }: Pick<TaskStory, "attempts" | "transport">): TransportState {
  if (state === "delivered") return "delivered";
  if (state === "withdrawn") return "cancelled";
  if (state === "bidding") return "waiting";
  return attempts.at(-1)?.legs.at(-1)?.aboard_at_s == null ? "assigned" : "on_board";
}

/** When its carrier has promised to be there; null once it has ended, and while nobody has. */
export function expectedS(transport: TransportAnswer): number | null {
  return hasEnded(transport) ? null : secondsOf(transport.expected_at);
}

/** Who carries it or brought it, and those before, each once; nobody while it is given out anew. */
export function carriersOf(story: Pick<TransportStory, "attempts">): { last: string; before: string[] } {
  const all = story.attempts.flatMap(({ legs }) => legs.map(({ carrier }) => carrier));
  const last = story.attempts.at(-1)?.legs.at(-1)?.carrier ?? "";
  return { last, before: [...new Set(all)].filter((carrier) => carrier !== last) };
}

/** When the first vehicle set off to fetch it, and when one first had it: of the last time that it was given out; null if not yet, or forgotten. */
export function stepsOf(story: Pick<TransportStory, "attempts">): { setOffS: number | null; aboardS: number | null } {
  const legs = story.attempts.at(-1)?.legs ?? [];
  return { setOffS: legs[0]?.since_at_s ?? null, aboardS: legs.find((leg) => leg.aboard_at_s !== null)?.aboard_at_s ?? null };
}

/** By how many seconds it is too late: of what was brought, or is expected, or by now. */
export function lateS(transport: TransportAnswer, nowS: number): number {
  if (transport.status === "cancelled") return 0;
  const thereS = secondsOf(transport.ended_at) ?? Math.max(nowS, expectedS(transport) ?? nowS);
  return Math.max(0, thereS - (secondsOf(transport.due_at) ?? thereS));
}

/** Where it is fetched; all places that it may be, with "/" between them, as long as no vehicle is on its way. */
export function sourceOf({ attempts, transport: { source } }: Pick<TaskStory, "attempts" | "transport">): string {
  const last = attempts.at(-1);
  return last !== undefined && last.legs.length > 0 ? last.source : source;
}
