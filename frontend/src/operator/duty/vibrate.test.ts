import { afterEach, expect, test, vi } from "vitest";
import { vibrate } from "./vibrate";

afterEach(() => { vi.unstubAllGlobals(); });

const vibrated = (navigator: object): boolean => {
  const called = vi.fn();
  vi.stubGlobal("navigator", { vibrate: called, ...navigator });
  vibrate();
  return called.mock.calls.length > 0;
};

test("a tablet vibrates once its page was touched", () => {
  expect(vibrated({ userActivation: { hasBeenActive: true } })).toBe(true);
  expect(vibrated({ userActivation: { hasBeenActive: false } })).toBe(false);
});

test("a browser that does not know who has touched its page vibrates", () => {
  expect(vibrated({})).toBe(true);
});

test("a computer that cannot vibrate is not asked to", () => {
  vi.stubGlobal("navigator", {});
  expect(vibrate).not.toThrow();
});
