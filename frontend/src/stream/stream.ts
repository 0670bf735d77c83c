/**
 * The stream as the panels use it: signals for people, calls for the map.
 *
 * Numbers on cards that change ten times a second cannot be read, so `world` moves at a reader's
 * pace; the map's motion listens to every frame instead.
 */
import { computed, signal } from "@preact/signals";
import { tellLoggedOut } from "../api/session";
import { Connection, type Socket } from "./connection";
import { freshnessOf } from "./freshness";
import { ServerClock } from "./server-clock";
import type { Frame, World } from "./world";

/** Four times a second: quicker than people read, slower than numbers flicker. */
const SHOW_EVERY_MS = 250;
/** The age of the picture is shown to a tenth of a second, but need not run like a stopwatch. */
const TICK_MS = 500;
/** A tab that nobody sees for so long is told once a second: whoever only looks elsewhere for a moment misses nothing. */
const HIDDEN_AFTER_MS = 10_000;

/** A frame comes at least once a second, and is shown a quarter of a second later at most. */
const FRAME_S = 1.5;

export const world = signal<World | null>(null);
export const connected = signal(false);
/** The server's clock, seconds since 1970, moving on even when no frames come. */
export const nowS = signal(Date.now() / 1000);

/**
 * The plant's present on the server's clock: of a plant that is behind, that of what is heard of it. It does not go on without
 * news: what does not reach this browser is nobody's silence.
 */
export const presentS = computed(() => presentOf(world.value, nowS.value));

const heardAtMs = signal<number | null>(null);
/** This browser's own clock, some times a second. */
export const tickMs = signal(performance.now());

/** Seconds since the last frame; null before the first one. */
export const ageS = computed(() =>
  heardAtMs.value === null ? null : Math.max(0, tickMs.value - heardAtMs.value) / 1000,
);
export const freshness = computed(() => freshnessOf(ageS.value, connected.value));

type FrameListener = (frame: Frame, world: World) => void;

const clock = new ServerClock(performance.timeOrigin / 1000);
const listeners = new Set<FrameListener>();
let newest: World | null = null;
let showing: number | null = null;
/** The pace of the stream that is open, or was opened last. */
let pace: "live" | "calm" = "live";

/** Hears every frame, up to ten a second. Returns how to stop. */
export function onFrame(listener: FrameListener): () => void {
  listeners.add(listener);
  return () => listeners.delete(listener);
}

export function serverNowS(): number {
  return clock.at(performance.now() / 1000);
}

/** As `presentS`, at this very moment. */
export function newestPresentS(): number {
  return presentOf(newest, serverNowS());
}

function presentOf(shown: World | null, serverS: number): number {
  return Math.min(serverS, (shown?.atS ?? Infinity) + FRAME_S) - (shown?.factory.behind_s ?? 0);
}

export function newestWorld(): World | null {
  return newest;
}

const connection = new Connection(
  {
    open: openSocket,
    later: (seconds, call) => {
      const timer = setTimeout(call, seconds * 1000);
      return () => {
        clearTimeout(timer);
      };
    },
    chance: Math.random,
  },
  {
    connected: (yes) => {
      connected.value = yes;
    },
    frame: take,
    loggedOut: tellLoggedOut,
    moved: () => {
      location.reload();
    },
  },
);

/** Tries at once instead of waiting for the next try. */
export function reconnect(): void {
  connection.connect();
}

/** Connects and stays connected for as long as the page lives. */
export function start(): void {
  addEventListener("online", () => {
    if (!connection.isOpen) connection.connect();
  });
  let hiding: number | undefined;
  document.addEventListener("visibilitychange", () => {
    clearTimeout(hiding);
    if (document.hidden) hiding = window.setTimeout(setPace, HIDDEN_AFTER_MS);
    else setPace();
  });
  setInterval(() => {
    tickMs.value = performance.now();
    if (newest !== null) nowS.value = serverNowS();
  }, TICK_MS);
  connection.connect();
}

/** Opens the stream anew where it should be told more often, or less. */
function setPace(): void {
  const wanted = document.hidden ? "calm" : "live";
  if (wanted === pace) return;
  pace = wanted;
  if (connection.isOpen) connection.connect();
}

function take(frame: Frame, after: World): void {
  const localMs = performance.now();
  if (frame.type === "snapshot") clock.reset();
  clock.note(frame.at_s, localMs / 1000);
  newest = after;
  for (const listener of listeners) listener(frame, after);
  if (frame.type === "snapshot") show();
  else showing ??= window.setTimeout(show, SHOW_EVERY_MS);
}

function show(): void {
  if (showing !== null) clearTimeout(showing);
  showing = null;
  world.value = newest;
  heardAtMs.value = tickMs.value = performance.now();
  nowS.value = serverNowS();
}

function openSocket(): Socket {
  const url = new URL(pace === "live" ? "/api/stream" : "/api/stream?pace=calm", location.href);
  url.protocol = url.protocol === "https:" ? "wss:" : "ws:";
  return new WebSocket(url) as Socket;
}
