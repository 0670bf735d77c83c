/** What the page of one plain transport draws and says, from what the gateway tells of it. Pure. */
import type { TransportAnswer, TransportStory } from "../../../../api/transports";
import { barsOfLeg, type Group, type Span } from "../../../orders/page/lanes";

/** What is shorter has no ticks that tell anything. */
const LEAST_SPAN_S = 60;

/** Room behind the last of it, as part of all. */
const ROOM_FRAC = 0.04;

export function secondsOf(moment: string | null): number | null {
  return moment === null ? null : Date.parse(moment) / 1000;
}

export function hasEnded({ ended_at }: TransportAnswer): boolean {
  return ended_at !== null;
}

/** How each time that it was given out is drawn. */
export function attemptsOf(story: TransportStory, untilS: number): Group["transports"] {
  return story.attempts.map((transport) => ({ transport, bars: transport.legs.flatMap((leg) => barsOfLeg(leg, untilS)) }));
}

/** From the call to the last of what has happened, is expected or due. */
export function spanOf(transport: TransportAnswer, story: TransportStory, untilS: number): Span {
  const fromS = secondsOf(transport.created_at) ?? untilS;
  const ends = [untilS, ...story.moments.map((moment) => moment.at_s), secondsOf(transport.due_at), expectedS(transport)].filter((atS) => atS !== null);
  const lastS = Math.max(fromS + LEAST_SPAN_S, ...ends);
  return { fromS, toS: lastS + (lastS - fromS) * ROOM_FRAC };
}

/** When its carrier has promised to be there; null once it has ended, and while nobody has. */
export function expectedS(transport: TransportAnswer): number | null {
  return hasEnded(transport) ? null : secondsOf(transport.expected_at);
}

/** Who carries it or brought it, and those before, each once. */
export function carriersOf(story: TransportStory): { last: string; before: string[] } {
  const all = story.attempts.flatMap(({ legs }) => legs.map(({ carrier }) => carrier));
  const last = all.at(-1) ?? "";
  return { last, before: [...new Set(all)].filter((carrier) => carrier !== last) };
}

/** By how many seconds it is too late: of what was brought, or is expected, or by now. */
export function lateS(transport: TransportAnswer, nowS: number): number {
  if (transport.status === "cancelled") return 0;
  const thereS = secondsOf(transport.ended_at) ?? Math.max(nowS, expectedS(transport) ?? nowS);
  return Math.max(0, thereS - (secondsOf(transport.due_at) ?? thereS));
}
