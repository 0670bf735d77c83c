import { beforeEach, describe, expect, test } from "vitest";
import { waitBeforeS } from "./backoff";
import { Connection, LOGGED_OUT, MOVED, type Socket } from "./connection";
import { freshnessOf, isPast } from "./freshness";
import { nothing } from "./nothing";
import { ServerClock } from "./server-clock";

class FakeSocket implements Socket {
  onopen: (() => void) | null = null;
  onmessage: ((event: { data: unknown }) => void) | null = null;
  onclose: ((event: { code: number }) => void) | null = null;
  closed = false;
  close(): void {
    this.closed = true;
  }
  say(frame: object): void {
    this.onmessage?.({ data: JSON.stringify(frame) });
  }
}

const empty = { at_s: 0, plant: "p", factory: {}, ...nothing, fault_injection: false, audience: null, gone: [] };
const snapshot = (number: number) => ({ ...empty, type: "snapshot", number });
const delta = (number: number) => ({ ...empty, type: "delta", number, factory: null });

let sockets: FakeSocket[];
let timers: { seconds: number; call: () => void; off: boolean }[];
let numbers: number[];
let states: boolean[];
let loggedOut: number;
let moved: number;
let connection: Connection;

const socket = (): FakeSocket => {
  const last = sockets.at(-1);
  if (!last) throw new Error("no socket was opened");
  return last;
};

/** Fires the timer that runs; returns how long it was. */
function passTime(): number {
  const running = timers.filter(({ off }) => !off);
  expect(running).toHaveLength(1);
  const [timer] = running;
  if (!timer) return NaN;
  timer.off = true;
  timer.call();
  return timer.seconds;
}

beforeEach(() => {
  [sockets, timers, numbers, states] = [[], [], [], []];
  [loggedOut, moved] = [0, 0];
  connection = new Connection(
    {
      open: () => {
        sockets.push(new FakeSocket());
        return socket();
      },
      later: (seconds, call) => {
        const timer = { seconds, call, off: false };
        timers.push(timer);
        return () => {
          timer.off = true;
        };
      },
      chance: () => 1,
    },
    {
      frame: (frame) => numbers.push(frame.number),
      connected: (yes) => states.push(yes),
      loggedOut: () => (loggedOut += 1),
      moved: () => (moved += 1),
    },
  );
  connection.connect();
  socket().onopen?.();
});

describe("a connection", () => {
  test("hands on a snapshot and the deltas that follow it", () => {
    socket().say(snapshot(4));
    socket().say(delta(5));
    expect(numbers).toEqual([4, 5]);
    expect(connection.isOpen).toBe(true);
  });

  test("connects anew when a frame is missing, and takes the fresh snapshot", () => {
    socket().say(snapshot(4));
    const first = socket();
    first.say(delta(6));
    expect(first.closed).toBe(true);
    passTime();
    socket().say(snapshot(9));
    expect(numbers).toEqual([4, 9]);
  });

  test("hears nothing more from a socket that it gave up", () => {
    const first = socket();
    const late = first.onmessage;
    first.say(delta(1));
    late?.({ data: "{}" });
    expect(first.onmessage).toBeNull();
    expect(numbers).toEqual([]);
  });

  test("waits longer after each failed try, and starts over once frames come", () => {
    socket().say(snapshot(1));
    socket().onclose?.({ code: 1006 });
    const waits = [0, 1, 2].map(() => {
      const wait = passTime();
      socket().onclose?.({ code: 1006 });
      return wait;
    });
    expect(waits).toEqual([0.5, 1, 2]);
    passTime();
    socket().onopen?.();
    socket().say(snapshot(2));
    socket().onclose?.({ code: 1006 });
    expect(passTime()).toBe(0.5);
  });

  test("gives up a socket that does not open", () => {
    connection.connect();
    expect(passTime()).toBeGreaterThan(1);
    expect(states.at(-1)).toBe(false);
  });

  test("takes nonsense for a lost connection", () => {
    socket().onmessage?.({ data: "<html>" });
    expect(states.at(-1)).toBe(false);
    expect(connection.isOpen).toBe(false);
  });

  test("is silent once closed", () => {
    connection.close();
    expect(timers.every(({ off }) => off)).toBe(true);
    expect(socket().closed).toBe(true);
  });

  test("whose session has ended says so, and does not try again by itself", () => {
    socket().say(snapshot(4));
    socket().onclose?.({ code: LOGGED_OUT });
    expect([loggedOut, states.at(-1), timers.every(({ off }) => off)]).toEqual([1, false, true]);
    connection.connect();
    expect(sockets).toHaveLength(2);
  });

  test("whose session works elsewhere now says so, which is no logout", () => {
    socket().say(snapshot(4));
    socket().onclose?.({ code: MOVED });
    expect([moved, loggedOut, states.at(-1), timers.every(({ off }) => off)]).toEqual([1, 0, false, true]);
  });
});

test("a wait is bounded, and differs by chance", () => {
  expect(waitBeforeS(30, 1)).toBeLessThanOrEqual(8);
  expect(waitBeforeS(0, 0)).toBeLessThan(waitBeforeS(0, 1));
});

test.each([
  [null, true, "connecting", false],
  [null, false, "offline", true],
  [0.4, true, "live", false],
  [3.5, true, "amber", false],
  [5.5, true, "stale", true],
  [1, false, "amber", false],
  [6, false, "offline", true],
] as const)("news of age %s, connected %s, is %s", (ageS, connected, freshness, past) => {
  expect(freshnessOf(ageS, connected)).toBe(freshness);
  expect(isPast(freshness)).toBe(past);
});

describe("the server's clock", () => {
  test("is known by the frame that came quickest", () => {
    const clock = new ServerClock();
    clock.note(1000, 10.3);
    clock.note(1001, 11.05);
    clock.note(1002, 12.4);
    expect(clock.at(12.4)).toBeCloseTo(1002.35, 2);
  });

  test("follows a drift, slowly", () => {
    const clock = new ServerClock();
    clock.note(1000, 0);
    for (let t = 1; t <= 2000; t += 1) clock.note(1000 + t * 0.9999, t);
    expect(clock.at(2000)).toBeCloseTo(1000 + 2000 * 0.9999, 1);
  });

  test("is our own as long as nothing was heard", () => {
    expect(new ServerClock(1000).at(42)).toBe(1042);
  });
});
