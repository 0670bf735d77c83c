import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import type * as Client from "./client";
import { onLoggedOut } from "./session";

const ORIGIN = "https://plant.example";
const STOPS = "https://plant.example:8443";
const ORDER = { customer: "Nordwerk", items: [{ product: "g2", quantity: 4 }], release: true };

/** A browser knows of which page a path is. */
class PageRequest extends Request {
  constructor(input: RequestInfo | URL, init?: RequestInit) {
    super(typeof input === "string" ? new URL(input, ORIGIN) : input, init);
  }
}

let client: typeof Client;
let asked: Request[];
let way: (request: Request, signal: AbortSignal) => Promise<Response>;
let ended: number;

beforeEach(async () => {
  [asked, ended] = [[], 0];
  onLoggedOut(() => { ended += 1; });
  vi.stubGlobal("Request", PageRequest);
  vi.stubGlobal("document", { querySelector: () => ({ content: STOPS }) });
  vi.stubGlobal("fetch", (request: Request, { signal }: { signal: AbortSignal }) => {
    asked.push(request);
    return way(request, signal);
  });
  client = await import("./client");
});

afterEach(() => {
  vi.unstubAllGlobals();
  vi.useRealTimers();
});

const answers = (body: unknown, status = 200) => () => Promise.resolve(Response.json(body, { status }));

describe("a request", () => {
  it("has its key and its body, and ends with the body of the answer", async () => {
    way = answers({ id: "O-1" }, 201);
    expect(await client.placeOrder(ORDER, "k1")).toEqual({ id: "O-1" });
    const [request] = asked;
    expect([request?.method, request?.url, request?.credentials]).toEqual(["POST", `${ORIGIN}/api/orders`, "same-origin"]);
    expect(request?.headers.get("Idempotency-Key")).toBe("k1");
    expect(request?.headers.get("Content-Type")).toBe("application/json");
    expect(await request?.json()).toEqual(ORDER);
  });

  it("writes an id into the path as one part of it", async () => {
    way = answers({});
    await client.readmit("ATV 1/2");
    expect(asked[0]?.url).toBe(`${ORIGIN}/api/agents/ATV%201%2F2/readmit`);
  });

  it("asks for a list by what is given, and leaves the rest out", async () => {
    way = answers({ items: [], next_cursor: null });
    await client.fetchAudit({ who: "anna & co", limit: 50 });
    expect(asked[0]?.url).toBe(`${ORIGIN}/api/audit?who=anna%20%26%20co&limit=50`);
  });

  it("needs no body in the answer where none is told of", async () => {
    way = () => Promise.resolve(new Response(null, { status: 204 }));
    await client.logOut();
    expect(asked[0]?.method).toBe("POST");
  });
});

describe("what goes wrong", () => {
  it("is the gateway's own problem where it tells one", async () => {
    way = answers({ type: "urn:dray:problem:unusable", title: "No", detail: "not so", errors: [{ field: "a", reason: "b" }] }, 422);
    await expect(client.placeOrder(ORDER, "k")).rejects.toMatchObject({
      name: "Problem", status: 422, message: "not so", kind: "unusable", errors: [{ field: "a", reason: "b" }],
    });
    expect(ended).toBe(0);
  });

  it("is a problem also where a proxy tells it as a page", async () => {
    way = () => Promise.resolve(new Response("<h1>Bad gateway</h1>", { status: 502 }));
    await expect(client.fetchPlant()).rejects.toMatchObject({ name: "Problem", status: 502 });
  });

  it("ends the session's view where nobody is logged in any more", async () => {
    way = answers({ title: "Not logged in" }, 401);
    await expect(client.fetchMe()).rejects.toMatchObject({ status: 401 });
    expect(ended).toBe(1);
  });

  it("is told from a request that has not left, which is sure", async () => {
    way = () => Promise.reject(new TypeError("Failed to fetch"));
    await expect(client.fetchPlant()).rejects.toMatchObject({ status: 0, kind: "not-sent" });
  });

  it("is not known where an answer has begun and cannot be read", async () => {
    for (const body of ["<html>", ""]) {
      way = () => Promise.resolve(new Response(body));
      await expect(client.fetchPlant()).rejects.toMatchObject({ name: "Problem", status: 0, kind: "" });
    }
  });

  it("is not known where patience has ended", async () => {
    vi.spyOn(AbortSignal, "timeout").mockReturnValue(AbortSignal.abort(new DOMException("over", "TimeoutError")));
    way = (_, signal) => Promise.reject(signal.reason as Error);
    await expect(client.fetchPlant()).rejects.toMatchObject({ status: 0, kind: "" });
  });
});

describe("a stop", () => {
  it("goes both ways under one name, with what the other origin knows the caller by", async () => {
    way = answers({ command: "c", done: true, reason: "" });
    await client.commandAtv("ATV1", { kind: "stop" });
    expect(asked.map(({ url, credentials }) => [url, credentials])).toEqual([
      [`${ORIGIN}/api/atvs/ATV1/commands`, "same-origin"],
      [`${STOPS}/api/atvs/ATV1/commands`, "include"],
    ]);
    const [one, other] = await Promise.all(asked.map((request) => request.json() as Promise<{ command: string }>));
    expect(one).toEqual(other);
    expect(one?.command).toMatch(/^[0-9a-f]{32}$/);
  });

  it("that is refused beside the gateway ends nobody's session", async () => {
    way = ({ url }) => answers({}, url.startsWith(STOPS) ? 401 : 503)();
    await expect(client.commandAtv("ATV1", { kind: "stop" })).rejects.toMatchObject({ status: 503 });
    expect(ended).toBe(0);
  });

  it("is the only command that goes more than one way", async () => {
    way = answers({ command: "c", done: true, reason: "" });
    await client.commandAtv("ATV1", { kind: "resume" });
    expect(asked).toHaveLength(1);
  });
});
