import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { bring } from "./bring";

const network = new EventTarget();

beforeEach(() => {
  vi.useFakeTimers();
  vi.stubGlobal("addEventListener", network.addEventListener.bind(network));
  vi.stubGlobal("removeEventListener", network.removeEventListener.bind(network));
});
afterEach(() => {
  vi.unstubAllGlobals();
  vi.useRealTimers();
});

/** A script that the network brings with the `nth` try. */
function script(nth: number) {
  return vi.fn(() => (load.mock.calls.length >= nth ? Promise.resolve("part") : Promise.reject(new TypeError("Failed to fetch"))));
}
let load = script(1);

test("what comes is shown once", async () => {
  load = script(1);
  const show = vi.fn();
  bring(load, show);
  await vi.runAllTimersAsync();
  network.dispatchEvent(new Event("online"));
  await vi.runAllTimersAsync();
  expect(show.mock.calls).toEqual([["part"]]);
  expect(load).toHaveBeenCalledTimes(1);
});

test("what the network does not bring is asked for until it comes, and each failure is told", async () => {
  load = script(4);
  const [show, failed] = [vi.fn(), vi.fn()];
  bring(load, show, failed);
  await vi.runAllTimersAsync();
  expect(show.mock.calls).toEqual([["part"]]);
  expect(failed).toHaveBeenCalledTimes(3);
});

test("it is asked for at once when the network is back, and not twice", async () => {
  load = script(2);
  const show = vi.fn();
  bring(load, show);
  network.dispatchEvent(new Event("online"));
  expect(load).toHaveBeenCalledTimes(1);
  await vi.advanceTimersByTimeAsync(0);
  network.dispatchEvent(new Event("online"));
  network.dispatchEvent(new Event("online"));
  await vi.advanceTimersByTimeAsync(0);
  expect(show.mock.calls).toEqual([["part"]]);
  await vi.runAllTimersAsync();
  expect(load).toHaveBeenCalledTimes(2);
});

test("what nobody wants any more is neither asked for nor shown", async () => {
  load = script(3);
  const [show, failed] = [vi.fn(), vi.fn()];
  const stop = bring(load, show, failed);
  await vi.advanceTimersByTimeAsync(0);
  stop();
  network.dispatchEvent(new Event("online"));
  await vi.runAllTimersAsync();
  expect(load).toHaveBeenCalledTimes(1);
  const late = script(1);
  bring(late, show, failed)();
  await vi.runAllTimersAsync();
  expect(show).not.toHaveBeenCalled();
  expect(failed).toHaveBeenCalledTimes(1);
});
