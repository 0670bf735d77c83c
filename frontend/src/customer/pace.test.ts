import { describe, expect, test } from "vitest";
import { isOffline, pauseS, withTime, zoneCookie } from "./pace";

describe("the page of a customer", () => {
  test("asks at the server's pace while it is answered", () => {
    expect(pauseS(5, 0)).toBe(5);
  });

  test("asks less often after each failure, and still every minute after very many", () => {
    expect([1, 2, 3, 4, 5000].map((failures) => pauseS(5, failures))).toEqual([10, 20, 40, 60, 60]);
  });

  test("says that it is offline after the second failure, not after one", () => {
    expect([0, 1, 2, 3].map(isOffline)).toEqual([false, false, true, true]);
  });

  test("puts the time into the server's sentence", () => {
    expect(withTime("Stand {time}", "13:10")).toBe("Stand 13:10");
  });

  test("sends its time zone to its own pages only, and over TLS only where there is TLS", () => {
    expect(zoneCookie("Europe/Madrid", false)).toBe("dray.zone=Europe/Madrid; path=/track; max-age=31536000; samesite=lax");
    expect(zoneCookie("Europe/Madrid", true)).toContain("; secure");
  });
});
