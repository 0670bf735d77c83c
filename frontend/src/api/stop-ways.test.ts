import { describe, expect, it } from "vitest";
import { Problem } from "./problem";
import { firstWord } from "./stop-ways";

const DONE = { done: true, reason: "" };
const NOT_SENT = new Problem(0, "", [], "not-sent");
const UNANSWERED = new Problem(0, "");
const SILENT = new Problem(504, "ATV1 has not answered");
const UNKNOWN = new Problem(401, "nobody is known by these credentials here", [], "not-logged-in");
const FORBIDDEN = new Problem(403, "not in your areas");
const AWAY = new Problem(503, "the database does not answer");

/** What comes of a stop whose ways end like this, in the order of their answers. */
async function go(gateway: unknown, beside: unknown): Promise<unknown> {
  const ends: Record<string, unknown> = { gateway, beside };
  return await firstWord(["gateway", "beside"], (way) =>
    ends[way] instanceof Problem ? Promise.reject(ends[way]) : (ends[way] as Promise<unknown>),
  ).catch((error: unknown) => error);
}

const NEVER = new Promise(() => undefined);

describe("a stop", () => {
  it("goes all ways at once, and takes the first answer", async () => {
    expect(await go(NEVER, Promise.resolve(DONE))).toBe(DONE);
    expect(await go(Promise.resolve(DONE), NEVER)).toBe(DONE);
  });

  it("needs one way only", async () => {
    expect(await go(Promise.resolve(DONE), NOT_SENT)).toBe(DONE);
    expect(await go(AWAY, Promise.resolve(DONE))).toBe(DONE);
    expect(await go(UNKNOWN, Promise.resolve(DONE))).toBe(DONE);
  });

  it("was not sent only if it went no way", async () => {
    expect(await go(NOT_SENT, NOT_SENT)).toBe(NOT_SENT);
    expect(await go(NOT_SENT, UNANSWERED)).toBe(UNANSWERED);
    expect(await go(UNKNOWN, NOT_SENT)).toBe(UNKNOWN);
  });

  it("is as uncertain as the way that may have led furthest", async () => {
    expect(await go(UNKNOWN, SILENT)).toBe(SILENT);
    expect(await go(SILENT, UNKNOWN)).toBe(SILENT);
    expect(await go(UNANSWERED, UNKNOWN)).toBe(UNANSWERED);
    expect(await go(AWAY, UNKNOWN)).toBe(AWAY);
  });

  it("is refused in the gateway's own words", async () => {
    expect(await go(FORBIDDEN, UNKNOWN)).toBe(FORBIDDEN);
  });

  it("goes by the gateway alone where there is no other way", async () => {
    expect(await firstWord(["gateway"], () => Promise.resolve(DONE))).toBe(DONE);
  });
});
