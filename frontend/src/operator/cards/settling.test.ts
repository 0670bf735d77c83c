import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { SETTLE_MS } from "../stop/places";
import { isSettling, settle } from "./settling";

beforeEach(() => { vi.useFakeTimers(); });
afterEach(() => { vi.useRealTimers(); });

const settling = () => ["ATV1", "ATV2", "ATV3"].filter(isSettling);

test("a card that has moved settles for a while, and from its last move on", () => {
  settle([]);
  settle(["ATV1", "ATV2"]);
  vi.advanceTimersByTime(SETTLE_MS - 1);
  expect(settling()).toEqual(["ATV1", "ATV2"]);
  settle(["ATV2", "ATV3"]);
  vi.advanceTimersByTime(1);
  expect(settling()).toEqual(["ATV2", "ATV3"]);
  vi.advanceTimersByTime(SETTLE_MS - 1);
  expect(settling()).toEqual([]);
});
