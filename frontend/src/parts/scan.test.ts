import { describe, expect, test } from "vitest";
import { NOTHING, pressed, type Scan } from "./scan";

/** The code that is read from keys so many milliseconds apart; null for none. */
function read(keys: readonly string[], apartMs: number): string | null {
  let scan: Scan = NOTHING;
  let found: string | null = null;
  keys.forEach((key, i) => {
    [scan, found] = pressed(scan, key, 1000 + i * apartMs);
  });
  return found;
}

describe("a scanner that types", () => {
  test("is read up to its Enter", () => {
    expect(read(["s", "h", "a", "f", "t", "*", "1", "2", "Enter"], 8)).toBe("shaft*12");
  });

  test("may press Shift in between", () => {
    expect(read(["Shift", "S", "h", "Shift", "*", "2", "Enter"], 8)).toBe("Sh*2");
  });

  test("is told from a hand by its speed", () => {
    expect(read(["o", "k", "Enter"], 400)).toBeNull();
  });

  test("is not an Enter alone, nor one key and Enter", () => {
    expect(read(["Enter"], 8)).toBeNull();
    expect(read([" ", "Enter"], 8)).toBeNull();
  });

  test("begins anew after a pause, and after each code", () => {
    const [stray] = pressed(NOTHING, "x", 1000);
    const [o] = pressed(stray, "o", 5000);
    const [ok] = pressed(o, "k", 5008);
    const [after, code] = pressed(ok, "Enter", 5016);
    expect(code).toBe("ok");
    expect(after).toEqual(NOTHING);
  });
});
