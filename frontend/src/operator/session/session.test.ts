import { beforeEach, describe, expect, test, vi } from "vitest";

const fetchMe = vi.hoisted(() => vi.fn());
vi.mock("../../api/client", () => ({ fetchMe, logOut: vi.fn() }));

const reload = vi.fn();
const settled = () => new Promise((done) => setTimeout(done));

beforeEach(() => {
  vi.resetModules();
  fetchMe.mockReset();
  reload.mockReset();
  vi.stubGlobal("document", { addEventListener: () => undefined, visibilityState: "visible" });
  vi.stubGlobal("location", { reload });
});

describe("a session that ends while the first answer about it is on its way", () => {
  test.each([
    ["was replaced", "session-replaced", "replaced"],
    ["was taken back", "not-logged-in", "taken_back"],
  ])("%s: the panel says so", async (_, kind, ending) => {
    const { Problem } = await import("../../api/problem");
    let answer: (me: object) => void = () => undefined;
    fetchMe.mockReturnValueOnce(new Promise((done) => (answer = done))).mockRejectedValueOnce(new Problem(401, "", [], kind));
    const { beginSession, ended } = await import("./session");
    const { tellLoggedOut } = await import("../../api/session");
    beginSession();
    tellLoggedOut();
    answer({ name: "north" });
    await settled();
    expect(ended.value).toBe(ending);
    expect(reload).not.toHaveBeenCalled();
  });

  test("somebody is logged in again by then: the panel begins anew", async () => {
    let answer: (me: object) => void = () => undefined;
    fetchMe.mockReturnValueOnce(new Promise((done) => (answer = done))).mockResolvedValueOnce({ name: "south" });
    const { beginSession } = await import("./session");
    const { tellLoggedOut } = await import("../../api/session");
    beginSession();
    tellLoggedOut();
    answer({ name: "north" });
    await settled();
    expect(reload).toHaveBeenCalledOnce();
  });
});
