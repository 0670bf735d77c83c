import { afterEach, expect, it, vi } from "vitest";
import { ask, asked, followAddress, go, view } from "./views";

afterEach(() => {
  vi.unstubAllGlobals();
});

/** A browser's address: whoever follows it is told of a change by hand. */
function browser(hash: string) {
  const told = new EventTarget();
  const location = { hash };
  const say = (_state: unknown, _title: string, address: string) => { location.hash = address; };
  vi.stubGlobal("location", location);
  vi.stubGlobal("history", { pushState: say, replaceState: say });
  vi.stubGlobal("addEventListener", told.addEventListener.bind(told));
  return { location, tell: () => told.dispatchEvent(new Event("hashchange")) };
}

it("leaves the address alone once somebody has followed a link, which is told of later", () => {
  const { location, tell } = browser("#plant");
  followAddress();
  location.hash = "#orders?state=late";
  ask({ at: "atv:ATV3" }, "replace");
  expect(location.hash).toBe("#orders?state=late");
  tell();
  expect([view.value, asked.value]).toEqual(["orders", { state: "late" }]);
  ask({ state: "open" });
  expect(location.hash).toBe("#orders?state=open");
  go("plant");
  tell();
  ask({ at: "atv:ATV3" });
  expect(asked.value).toEqual({ at: "atv:ATV3" });
});
