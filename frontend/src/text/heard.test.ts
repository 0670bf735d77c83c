import { expect, test } from "vitest";
import { sinceHeard, sinceHeardIn } from "./heard";

test("how long ago somebody was heard is told by the factory's clock, and says so where that is another one", () => {
  expect(sinceHeard(2.5, 1)).toBe("2.5\u202fs");
  expect(sinceHeard(2.5, 10)).toContain("25\u202fs of factory time");
  expect(sinceHeardIn(2.5, 10)).toBe("25\u202fs");
  expect(sinceHeardIn(-1, 10)).toBe(sinceHeardIn(0, 1));
});
