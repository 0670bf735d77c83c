/** What an order's lanes show: goals and transports as bars in time. Pure. */
import type { components } from "../../../api/types";

export type Story = components["schemas"]["OrderStory"];
export type Goal = components["schemas"]["OrderGoalView"];
export type Transport = components["schemas"]["WayOutView"];
export type Leg = components["schemas"]["LegView"];

/** `fetch`: to the source; `carry`: with the load; `lost`: replaced on the way; `waits`: a machine has it and makes something else, or lacks material; `made`: a machine works; `open`: what is still to come; `expected`: when all of it may be delivered. */
export type BarKind = "fetch" | "carry" | "lost" | "waits" | "made" | "open" | "expected";

export interface Bar {
  readonly kind: BarKind;
  readonly fromS: number;
  readonly toS: number;
}

/** Wall clock, seconds. */
export interface Span {
  readonly fromS: number;
  readonly toS: number;
}

/** A moment that is drawn through all lanes, with its time at the head of the axis. */
export interface Sign {
  readonly kind: "now" | "due";
  readonly atS: number;
  /** Lines above the lanes: 0 stands on them, 1 has another sign below itself. */
  readonly row: 0 | 1;
}

/** A goal, and the transports of what it has made. */
export interface Group {
  readonly goal: Goal;
  readonly bars: readonly Bar[];
  readonly transports: readonly { transport: Transport; bars: readonly Bar[] }[];
}

const HOUR_S = 3600;
const STEPS_S = [1, 2, 5, 10, 30, 60, 120, 300, 600, 900, 1800, HOUR_S, 2 * HOUR_S, 6 * HOUR_S, 12 * HOUR_S, 24 * HOUR_S, 168 * HOUR_S];
/** What has just begun has this much of an axis, so that it does not move with every second. What has ended needs less. */
const LEAST_SPAN_S = 60;
const LEAST_ENDED_S = 5;
/** Room behind the last of it, as part of all. */
const ROOM_FRAC = 0.04;
/** Two signs that are nearer have no room beside one another. */
const SIGNS_APART_PERCENT = 30;

/** @param hasEnded nothing is still to come then */
export function groupsOf(story: Story, nowS: number, hasEnded = false): Group[] {
  return story.goals.map((goal) => ({
    goal,
    bars: barsOfGoal(goal, nowS).filter(({ kind }) => !hasEnded || kind !== "open"),
    transports: story.transports
      .filter((transport) => transport.goal === goal.goal)
      .map((transport) => ({ transport, bars: transport.legs.flatMap((leg) => barsOfLeg(leg, nowS)) })),
  }));
}

export function barsOfGoal(goal: Goal, nowS: number): Bar[] {
  const { ended_at_s: endedS, last_at_s: lastS, promised_at_s: promisedS, taken_at_s: takenS } = goal;
  const isDone = goal.made >= goal.quantity || goal.ended !== "";
  const untilS = isDone ? (endedS ?? lastS ?? nowS) : nowS;
  const works = worksOf(goal, untilS, isDone);
  const sinceS = takenS ?? works[0]?.fromS ?? null;
  if (sinceS === null) return [];
  const bars: Bar[] = [];
  let atS = sinceS;
  for (const { fromS, toS } of works) {
    bars.push({ kind: "waits", fromS: atS, toS: fromS }, { kind: "made", fromS: Math.max(atS, fromS), toS });
    atS = Math.max(atS, toS);
  }
  bars.push({ kind: "waits", fromS: atS, toS: untilS });
  if (!isDone && promisedS !== null) bars.push({ kind: "open", fromS: untilS, toS: promisedS });
  return bars.filter((bar) => bar.toS > bar.fromS);
}

/** When its machine has worked at a goal, as far as that is told, oldest first. */
function worksOf(goal: Goal, untilS: number, isDone: boolean): Span[] {
  const { begun_at_s: begunS, doing_since_at_s: doingS, last_at_s: lastS, made, taken_at_s: takenS } = goal;
  const present = goal.doing === "making" && doingS !== null ? [{ fromS: Math.min(doingS, untilS), toS: untilS }] : [];
  const pieceS = made > 1 && begunS !== null && lastS !== null ? (lastS - begunS) / (made - 1) : 0;
  // Before the first piece came out, the machine has worked at it: as long as at each of the others.
  const firstS = begunS === null ? (made > 0 ? takenS : null) : begunS - pieceS;
  if (firstS === null) return present;
  const endS = isDone && goal.ended === "" ? untilS : (lastS ?? untilS);
  // Between two pieces it works.
  const goesOn = present.some(({ fromS }) => fromS <= endS + pieceS);
  return goesOn ? [{ fromS: Math.min(firstS, ...present.map(({ fromS }) => fromS)), toS: untilS }] : [{ fromS: firstS, toS: endS }, ...present];
}

export function barsOfLeg(leg: Leg, nowS: number): Bar[] {
  const untilS = Math.max(leg.since_at_s, leg.until_at_s ?? nowS);
  if (leg.replaced !== "") return [{ kind: "lost", fromS: leg.since_at_s, toS: untilS }];
  const aboardS = leg.aboard_at_s;
  if (aboardS === null) return [{ kind: "fetch", fromS: leg.since_at_s, toS: untilS }];
  return [
    { kind: "fetch", fromS: leg.since_at_s, toS: aboardS },
    { kind: "carry", fromS: aboardS, toS: Math.max(aboardS, untilS) },
  ];
}

/** What the legend names, as far as it is drawn. */
export function legendOf(isClosed: boolean, isDue: boolean, isExpected: boolean): (BarKind | Sign["kind"])[] {
  return [
    "fetch", "carry", "lost", "waits", "made",
    ...(isClosed ? [] : ["open" as const]),
    ...(isExpected ? ["expected" as const] : []),
    ...(isClosed ? [] : ["now" as const]),
    ...(isDue ? ["due" as const] : []),
  ];
}

/** From the earliest to the latest moment at which all of the order may be delivered, neither of them past; nothing where nobody can tell. */
export function barsOfExpected(expected: Story["expected"], nowS: number): Bar[] {
  if (expected === null) return [];
  const fromS = Math.max(expected.from_at_s, nowS);
  return [{ kind: "expected", fromS, toS: Math.max(fromS, expected.to_at_s) }];
}

/** Now, while the order goes on, and when it is due. */
export function signsOf(span: Span, nowS: number, dueS: number | null): Sign[] {
  const now: Sign[] = nowS < span.toS ? [{ kind: "now", atS: nowS, row: 0 }] : [];
  if (dueS === null) return now;
  const isNear = now.some(({ atS }) => Math.abs(percentOf(span, atS) - percentOf(span, dueS)) < SIGNS_APART_PERCENT);
  return [...now, { kind: "due", atS: dueS, row: isNear ? 1 : 0 }];
}

/** When it is due, as far as the axis shows that: the axis of what has ended does not run on to a time that was not needed. */
export function dueOnAxis(dueS: number | null, endedS: number | null): number | null {
  return dueS !== null && endedS !== null && dueS > endedS ? null : dueS;
}

/** From the first of an order to the last of it, with what is expected and due, and a little room at the end. */
export function spanOf(groups: readonly Group[], marks: readonly (number | null)[], startS: number, hasEnded = false): Span {
  const bars = groups.flatMap((group) => [...group.bars, ...group.transports.flatMap((each) => each.bars)]);
  const ends = [...bars.map((bar) => bar.toS), ...marks.filter((mark) => mark !== null)];
  const fromS = Math.min(startS, ...bars.map((bar) => bar.fromS));
  return spanBetween(fromS, ends, hasEnded);
}

/** From a moment to the last of some others, with a little room behind it. */
export function spanBetween(fromS: number, ends: readonly number[], hasEnded: boolean): Span {
  const lastS = Math.max(fromS + (hasEnded ? LEAST_ENDED_S : LEAST_SPAN_S), ...ends);
  return { fromS, toS: lastS + (lastS - fromS) * ROOM_FRAC };
}

/** How far along the span a moment lies, in percent; what lies outside is at its edge. */
export function percentOf(span: Span, atS: number): number {
  return Math.min(100, Math.max(0, ((atS - span.fromS) / (span.toS - span.fromS)) * 100));
}

/** Round times within the span, `most` of them at most. */
export function ticksOf(span: Span, most: number): number[] {
  const lengthS = span.toS - span.fromS;
  const stepS = STEPS_S.find((step) => lengthS / step <= most) ?? lengthS;
  const ticks: number[] = [];
  for (let atS = Math.ceil(span.fromS / stepS) * stepS; atS < span.toS; atS += stepS) ticks.push(atS);
  return ticks;
}
