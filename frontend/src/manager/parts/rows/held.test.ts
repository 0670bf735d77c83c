import { expect, test } from "vitest";
import { heldKey, machineHeldKey } from "./held";

test("what held a carrier up has a sentence of vehicles or of machines, and what is not known has none", () => {
  expect(heldKey("waits", "ATV4")).toBe("waitsFor");
  expect(heldKey("waits", "")).toBe("waits");
  expect(heldKey("blocked", "drive")).toBe("blocked");
  expect(machineHeldKey("blocked", "")).toBe("notFetched");
  expect(machineHeldKey("starves", "rotor")).toBe("starvesFor");
  expect([heldKey("", ""), heldKey("dances", ""), machineHeldKey("waits", "ATV4")]).toEqual([null, null, null]);
});
