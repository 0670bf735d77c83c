import { describe, expect, test } from "vitest";
import { arrivalOf } from "./arrival";

const asked = {
  atv: { status: "working", problem: "" } as const, dueAtS: 1100, promisedAtS: 1100, lost: false, waits: false, nowS: 1000, speed: 1,
};

describe("when it hands over is said", () => {
  test("as promised only of who drives, is heard and has not missed it", () => {
    expect(arrivalOf(asked)).toEqual({ kind: "expected", atS: 1100, word: "onTime", byS: 0 });
    expect(arrivalOf({ ...asked, promisedAtS: 1000 })).toEqual({ kind: "expected", atS: 1100, word: "late", byS: 100 });
    expect(arrivalOf({ ...asked, promisedAtS: 1150, speed: 2 })).toEqual({ kind: "expected", atS: 1100, word: "early", byS: 100 });
    expect(arrivalOf({ ...asked, promisedAtS: null })).toEqual({ kind: "expected", atS: 1100, word: null, byS: 0 });
  });

  test("of nobody who is silent, stopped or broken", () => {
    expect(arrivalOf({ ...asked, lost: true })).toEqual({ kind: "silent" });
    expect(arrivalOf({ ...asked, atv: { status: "stopped", problem: "" } })).toEqual({ kind: "stands" });
    expect(arrivalOf({ ...asked, atv: { status: "error", problem: "drive" } })).toEqual({ kind: "stands" });
    expect(arrivalOf({ ...asked, atv: { status: "working", problem: "drive" } })).toEqual({ kind: "stands" });
  });

  test("of who waits for others only how late it is already", () => {
    expect(arrivalOf({ ...asked, waits: true })).toEqual({ kind: "heldUp", lateS: null });
    expect(arrivalOf({ ...asked, waits: true, nowS: 1340, dueAtS: 1090 })).toEqual({ kind: "heldUp", lateS: 240 });
  });

  test("as a time that has passed, where it has", () => {
    expect(arrivalOf({ ...asked, nowS: 1104 })).toEqual({ kind: "overdue", atS: 1100, byS: 4 });
  });

  test("never as on time in any state in which it is not", () => {
    let said = 0;
    for (const status of ["idle", "working", "charging", "stopped", "error"] as const)
      for (const problem of ["", "drive"]) for (const lost of [false, true]) for (const waits of [false, true])
        for (const nowS of [900, 1000, 1099, 1103, 2000]) for (const promisedAtS of [null, 900, 1099, 1100, 1300]) {
          const arrival = arrivalOf({ ...asked, atv: { status, problem }, lost, waits, nowS, promisedAtS });
          if (arrival.kind !== "expected" || arrival.word !== "onTime") continue;
          said++;
          const stands = status === "stopped" || status === "error" || problem !== "";
          expect([lost, waits, stands, nowS > 1102]).toEqual([false, false, false, false]);
          expect(Math.abs(Math.max(1100, nowS) - (promisedAtS ?? Infinity))).toBeLessThanOrEqual(2);
        }
    expect(said).toBeGreaterThan(10);
  });
});
