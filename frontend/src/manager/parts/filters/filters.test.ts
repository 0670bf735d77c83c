import { describe, expect, test } from "vitest";
import type { OrderView, TaskView } from "../../../api/types";
import * as orders from "../../orders/filter";
import * as tasks from "../../pages/tasks/filter";
import { holds } from "./match";

const names = (id: string): string => (id === "g2" ? "Gear unit G2" : id);

describe("words that are looked for", () => {
  test("may stand anywhere, in any order and case", () => {
    expect(holds("nord gear", "PO-17", "Nordwerk", "Gear unit G2")).toBe(true);
    expect(holds("nord pump", "PO-17", "Nordwerk", "Gear unit G2")).toBe(false);
    expect(holds("  ", null)).toBe(true);
  });
});

describe("orders", () => {
  const order = {
    id: "O-1", customer: "Nordwerk", reference: "PO-17", status: "in_production", due_at_s: 50, delivered_at_s: null,
    items: [{ product: "g2", quantity: 4, made: 0, delivered: 0 }],
  } as unknown as OrderView;
  const any: orders.Wanted = { words: "", status: "", product: "", late: false };
  const wanted = (by: Partial<orders.Wanted>, nowS = 40): boolean => orders.isWanted(order, { ...any, ...by }, nowS, names);

  test("are told apart by status, product, lateness and words", () => {
    expect([wanted({}), wanted({ status: "open" }), wanted({ status: "in_production" }), wanted({ product: "g2" })]).toEqual(
      [true, true, true, true],
    );
    expect([wanted({ status: "delivered" }), wanted({ product: "p3" }), wanted({ late: true }), wanted({ words: "pump" })]).toEqual(
      [false, false, false, false],
    );
    expect(wanted({ late: true, words: "gear po-17" }, 60)).toBe(true);
  });

  test("come as a table of the same status", () => {
    expect(orders.tableOf(any)).toBe("/api/orders?format=csv");
    expect(orders.tableOf({ ...any, status: "delivered" })).toBe("/api/orders?status=delivered&format=csv");
    expect(orders.tableOf({ ...any, status: "open" })).toContain("status=stored&status=released&status=in_production&");
  });
});

describe("tasks", () => {
  const task = {
    id: "M8-3", coordinator: "M8", item: "g2", primary: "ATV3", secondary: "ATV1", destination: "M8", state: "contracted",
    promised_at_s: 50, closed_at_s: null,
  } as unknown as TaskView;
  const any: tasks.Wanted = { words: "", state: "", item: "", late: false };

  test("are told apart by state, item and words", () => {
    const wanted = (by: Partial<tasks.Wanted>): boolean => tasks.isWanted(task, { ...any, ...by }, 40, names);
    expect([wanted({}), wanted({ state: "contracted", item: "g2", words: "atv1" })]).toEqual([true, true]);
    expect([wanted({ state: "delivered" }), wanted({ item: "x" }), wanted({ late: true }), wanted({ words: "M9" })]).toEqual(
      [false, false, false, false],
    );
  });

  test("are late once their promise has passed, or was passed when they ended", () => {
    expect([tasks.isLate(task, 40), tasks.isLate(task, 60)]).toEqual([false, true]);
    expect(tasks.isLate({ ...task, state: "delivered", closed_at_s: 45 }, 60)).toBe(false);
    expect(tasks.isLate({ ...task, state: "withdrawn" }, 60)).toBe(false);
  });
});
