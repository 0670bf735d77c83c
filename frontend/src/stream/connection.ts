/**
 * Keeps one websocket open: connects, hands on frames, reconnects with growing waits, and asks for a
 * fresh snapshot (by connecting anew) when a frame is missing or makes no sense.
 */
import { waitBeforeS } from "./backoff";
import { advance, type Frame, type World } from "./world";

/** The part of a WebSocket that is used, so that tests can stand in for it. */
export interface Socket {
  onopen: (() => void) | null;
  onmessage: ((event: { data: unknown }) => void) | null;
  onclose: ((event: { code: number }) => void) | null;
  close(): void;
}

export interface Surroundings {
  open: () => Socket;
  /** Calls back after a while; what it returns cancels. */
  later: (seconds: number, call: () => void) => () => void;
  chance: () => number;
}

export interface Listener {
  /** A frame was taken in; `world` is what it led to. */
  frame: (frame: Frame, world: World) => void;
  connected: (yes: boolean) => void;
  /** The session has ended, or there is none: nothing comes before somebody has logged in. */
  loggedOut: () => void;
  /** Whoever is logged in may see something else by now, or works elsewhere. */
  moved: () => void;
}

/** With this code the gateway closes the stream of a session that has ended. */
export const LOGGED_OUT = 4401;
/** And with this one the stream of a session whose station or areas are others now. */
export const MOVED = 4409;

/** How long a socket may take to open before it is given up. */
const OPEN_WITHIN_S = 6;

export class Connection {
  readonly #around: Surroundings;
  readonly #listener: Listener;
  #socket: Socket | null = null;
  #world: World | null = null;
  #failures = 0;
  #cancelTimer: () => void = () => undefined;

  constructor(around: Surroundings, listener: Listener) {
    this.#around = around;
    this.#listener = listener;
  }

  /** Connects now, whatever wait was running: at the start, and when the network came back. */
  connect(): void {
    this.#drop();
    this.#world = null;
    const socket = this.#around.open();
    this.#socket = socket;
    socket.onopen = () => {
      this.#cancelTimer();
      this.#listener.connected(true);
    };
    socket.onmessage = (event) => {
      this.#take(event.data);
    };
    socket.onclose = ({ code }) => {
      if (code === LOGGED_OUT) this.#end(this.#listener.loggedOut);
      else if (code === MOVED) this.#end(this.#listener.moved);
      else this.#lost();
    };
    this.#cancelTimer = this.#around.later(OPEN_WITHIN_S, () => {
      this.#lost();
    });
  }

  /** Whether frames are coming; false while it waits for its next try. */
  get isOpen(): boolean {
    return this.#world !== null;
  }

  close(): void {
    this.#drop();
  }

  #take(data: unknown): void {
    const frame = parse(data);
    const world = frame && advance(this.#world, frame);
    if (!frame || !world) {
      this.#lost();
      return;
    }
    this.#world = world;
    this.#failures = 0;
    this.#listener.frame(frame, world);
  }

  /** Nothing more comes by itself; `connect` may be called again. */
  #end(tell: () => void): void {
    this.#drop();
    this.#world = null;
    this.#listener.connected(false);
    tell();
  }

  #lost(): void {
    this.#drop();
    this.#world = null;
    this.#listener.connected(false);
    const wait = waitBeforeS(this.#failures, this.#around.chance());
    this.#failures += 1;
    this.#cancelTimer = this.#around.later(wait, () => {
      this.connect();
    });
  }

  #drop(): void {
    this.#cancelTimer();
    const socket = this.#socket;
    this.#socket = null;
    if (!socket) return;
    // A closing socket may still deliver; nothing it says counts any more.
    socket.onopen = socket.onmessage = socket.onclose = null;
    socket.close();
  }
}

function parse(data: unknown): Frame | null {
  if (typeof data !== "string") return null;
  try {
    const frame = JSON.parse(data) as Frame;
    return typeof frame.number === "number" ? frame : null;
  } catch {
    return null;
  }
}
