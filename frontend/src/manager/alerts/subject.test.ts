import { afterEach, beforeEach, describe, expect, test, vi } from "vitest";
import type { AlertView } from "../../api/types";
import { orderOf, showSubject, subjectOf } from "./subject";

const alert = (more: Partial<AlertView>): AlertView => ({
  id: "x", kind: "order_late", level: "warning", response: "tell_customer", since_at_s: 100, agent: "", task: "", order: "", place: "",
  agents: [], call: null, keepers: [], cause: null, goods: null, doubt: null, by: "", seen_at_s: null, access_point: "", until_at_s: null,
  battery_frac: null, behind_s: null, clock_ahead_s: null, waiting: null, carried_frac: null,
  acknowledged_by: "", acknowledged_at_s: null, acknowledged_until_at_s: null, came_back: null, comment: "", comment_by: "", ...more,
});
const goods = { item: "g2", name: "Gear unit G2", quantity: 4, machine: "M9", order_name: "PO-17", node: "", handed_at: "" };

describe("an alert leads", () => {
  const address = { hash: "" };
  beforeEach(() => { vi.stubGlobal("location", address); });
  afterEach(() => { vi.unstubAllGlobals(); });

  const leadsTo = (one: AlertView): string => {
    showSubject(one);
    return address.hash;
  };

  test("to the page of the order by whose name it is told", () => {
    expect(leadsTo(alert({ order: "O-1" }))).toBe("#orders/O-1");
    expect(leadsTo(alert({ order: "O-1", task: "M9-1", goods }))).toBe("#orders/O-1");
  });

  test("to the plant for all else", () => {
    expect(leadsTo(alert({ kind: "machine_error", agent: "M8" }))).toBe("plant");
    expect(leadsTo(alert({ kind: "overloaded" }))).toBe("plant");
    expect(leadsTo(alert({ kind: "goods_stranded", order: "O-1", task: "M9-1", agent: "ATV3", goods }))).toBe("plant");
  });
});

test("goods are told by the vehicle that has them, and not by their order", () => {
  const stranded = alert({ order: "O-1", agent: "ATV3", goods });
  expect([subjectOf(stranded), orderOf(stranded)]).toEqual(["ATV3", ""]);
  const unknown = alert({ order: "O-1", goods });
  expect([subjectOf(unknown), orderOf(unknown)]).toEqual(["O-1", "O-1"]);
});

test("the gate is told by what people call it", () => {
  expect(subjectOf(alert({ kind: "gate_error", agent: "gate" }))).toBe("Delivery gate");
  expect(subjectOf(alert({ kind: "station_lost", agent: "S3" }))).toBe("S3");
});
