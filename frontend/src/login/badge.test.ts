import { describe, expect, test } from "vitest";
import { isBadge } from "./badge";

describe("what a reader has typed", () => {
  test.each([
    ["04A2B9C1", false, true],
    ["04A2B9C1", true, true],
    ["12345678", false, true],
    // A quick hand's PIN.
    ["12345678", true, false],
    ["1234567890123", true, true],
    ["ok", false, false],
  ])("%s, in the PIN's field: %s, is a badge: %s", (code, inPin, is) => {
    expect(isBadge(code, inPin)).toBe(is);
  });
});
