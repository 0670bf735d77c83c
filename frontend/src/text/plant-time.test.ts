import { beforeEach, expect, test } from "vitest";
import { en } from "./manager/en";
import { factorySeconds, factoryTime, inFactoryTime, ofFactoryTime } from "./plant-time";
import { speak } from "./speech";

/** Figures and units are kept together by a narrow space that does not break. */
const plain = (text: string): string => text.replaceAll("\u202f", " ");

beforeEach(() => {
  speak("en", en, "en-GB");
});

test("a length of factory time says so where that clock runs otherwise than the one on the wall", () => {
  expect(plain(factoryTime(16, 1))).toBe("16 s");
  expect(plain(factoryTime(16, 20))).toBe("16 s of factory time");
  expect(plain(factoryTime(16.04, 20, "price"))).toBe("16.0 s of factory time");
});

test("so do a head above such figures, and a text that is full of them", () => {
  expect(inFactoryTime("Queue", 1)).toBe("Queue");
  expect(inFactoryTime("Queue", 20)).toBe("Queue (factory time)");
  expect(ofFactoryTime("It took 16 s.", 1)).toBe("It took 16 s.");
  expect(ofFactoryTime("It took 16 s.", 0.5)).toBe("It took 16 s. Durations here are factory time.");
});

test("a second of the clock on the wall is as many of the factory's as that clock is faster", () => {
  expect(factorySeconds(2, 30)).toBe(60);
  expect(factorySeconds(2)).toBe(2);
});

test("before anything is heard of the plant its clock is taken for the one on the wall", () => {
  expect(plain(factoryTime(16))).toBe("16 s");
});
