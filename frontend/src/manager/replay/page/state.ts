/** The moment that is shown, and how it goes on. */
import { computed, signal } from "@preact/signals";
import { Problem } from "../../../api/problem";
import type { Source } from "../../../plant/surface/source";
import { serverNowS } from "../../../stream/stream";
import type { Frame, World } from "../../../stream/world";
import { problemText } from "../../problem-text";
import { fetchFilm } from "./api";
import { aheadS, everyS, type Mark, type Overview, play, type Reel, reelOf } from "./film";

/** The past ends a little before now: the newest frames are on their way. */
const LIVE_EDGE_S = 2;
const TICK_MS = 100;
/** People who drag a slider ask for some moments a second, and look at the last one. */
const SETTLE_MS = 120;

export const RATES = [0.25, 1, 4, 16, 60] as const;

export const atS = signal(0);
export const playing = signal(false);
export const rate = signal<number>(1);
/** The plant as it was; null before the first picture. */
export const past = signal<World | null>(null);
export const failed = signal<string | null>(null);
/** Nothing is kept of the moment that was asked for, nor of any before it. */
export const notKept = signal(false);
export const overview = signal<Overview | null>(null);
/** The moment in whole seconds: what is asked for anew when it changes. */
export const secondS = computed(() => Math.floor(atS.value));

let reel: Reel | null = null;
let coming: Reel | null = null;
let fetching = false;
/** Whoever has asked since makes an answer worthless. */
let turn = 0;
let settling: number | undefined;
const listeners = new Set<(frame: Frame, world: World) => void>();

export const SOURCE: Source = {
  newest: () => past.peek(),
  onFrame: (listener) => {
    listeners.add(listener);
    return () => listeners.delete(listener);
  },
  presentS: () => atS.peek(),
};

function tell(frame: Frame, world: World): void {
  for (const listener of listeners) listener(frame, world);
}

/** All of a picture, as if it were the first one. */
function tellWhole(world: World): void {
  tell({ type: "snapshot" } as Frame, world);
}

export function edgeS(): number {
  return serverNowS() - LIVE_EDGE_S;
}

/** Shows another moment. */
export function seek(toS: number): void {
  atS.value = Math.min(toS, edgeS());
  turn += 1;
  const mine = turn;
  coming = null;
  clearTimeout(settling);
  settling = window.setTimeout(() => void load(mine), past.peek() === null ? 0 : SETTLE_MS);
}

async function load(mine: number): Promise<void> {
  const fromS = atS.peek();
  const untilS = playing.peek() ? Math.min(edgeS(), fromS + aheadS(rate.peek())) : fromS;
  fetching = true;
  try {
    const found = reelOf(await fetchFilm(fromS, untilS, everyS(rate.peek())));
    if (mine !== turn) return;
    reel = found;
    past.value = found.world;
    failed.value = null;
    notKept.value = false;
    tellWhole(found.world);
  } catch (error) {
    if (mine === turn) {
      notKept.value = error instanceof Problem && error.kind === "not-kept";
      failed.value = notKept.value ? null : problemText(error);
      playing.value = false;
    }
  } finally {
    if (mine === turn) fetching = false;
  }
}

export function setPlaying(yes: boolean): void {
  playing.value = yes;
  if (yes) seek(atS.peek());
}

export function setRate(to: number): void {
  rate.value = to;
  if (playing.peek()) seek(atS.peek());
}

export function seekMark(mark: Mark | null): void {
  if (mark) seek(mark.at_s);
}

/** Lets time go on while somebody looks. Returns how to stop. */
export function run(): () => void {
  let lastMs = performance.now();
  const timer = setInterval(() => {
    const nowMs = performance.now();
    const passedS = (nowMs - lastMs) / 1000;
    lastMs = nowMs;
    if (playing.peek()) step(passedS);
  }, TICK_MS);
  return () => {
    clearInterval(timer);
    clearTimeout(settling);
    playing.value = false;
    turn += 1;
  };
}

function step(passedS: number): void {
  if (reel === null || fetchingFirst()) return;
  const wantedS = Math.min(atS.peek() + passedS * rate.peek(), edgeS());
  if (wantedS >= reel.untilS && coming) {
    reel = coming;
    coming = null;
  }
  const nextS = Math.min(wantedS, Math.max(reel.untilS, atS.peek()));
  const { reel: after, shown } = play(reel, nextS);
  reel = after;
  atS.value = nextS;
  past.value = after.world;
  // At its own pace it moves as it did; where time runs, every picture stands for itself.
  if (rate.peek() === 1) for (const frame of shown) tell(frame, after.world);
  else if (shown.length > 0) tellWhole(after.world);
  if (nextS >= edgeS() - 0.1) playing.value = false;
  else if (reel.untilS - nextS < aheadS(rate.peek()) / 3 && coming === null && !fetching) void loadMore(reel.untilS, turn);
}

function fetchingFirst(): boolean {
  return fetching && coming === null && reel !== null && atS.peek() > reel.untilS;
}

async function loadMore(fromS: number, mine: number): Promise<void> {
  const untilS = Math.min(edgeS(), fromS + aheadS(rate.peek()));
  if (untilS <= fromS + 0.5) return;
  fetching = true;
  try {
    const found = reelOf(await fetchFilm(fromS, untilS, everyS(rate.peek())));
    if (mine === turn) coming = found;
  } catch (error) {
    if (mine === turn) {
      failed.value = problemText(error);
      playing.value = false;
    }
  } finally {
    if (mine === turn) fetching = false;
  }
}
