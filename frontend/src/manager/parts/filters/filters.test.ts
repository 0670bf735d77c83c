import { describe, expect, test } from "vitest";
import * as orders from "../../orders/filter";
import * as tasks from "../../pages/tasks/filter";
import { askedFrom, addressWith, namedIn, viewFrom } from "../../views";
import { holds } from "./match";

describe("words that are looked for", () => {
  test("may stand anywhere, in any order and case", () => {
    expect(holds("nord gear", "PO-17", "Nordwerk", "Gear unit G2")).toBe(true);
    expect(holds("nord pump", "PO-17", "Nordwerk", "Gear unit G2")).toBe(false);
    expect(holds("  ", null)).toBe(true);
  });
});

describe("the address", () => {
  test("says what is looked for, beside the view and the order", () => {
    const address = addressWith("#orders", { q: "D5 & more", status: "open", late: "" });
    expect(address).toBe("#orders?q=D5+%26+more&status=open");
    expect(askedFrom(address)).toEqual({ q: "D5 & more", status: "open" });
    expect([viewFrom(address), namedIn(address, "orders")]).toEqual(["orders", ""]);
    expect(namedIn("#orders/O-1?q=D5", "orders")).toBe("O-1");
    expect(askedFrom("#orders/O-1")).toEqual({});
  });
});

describe("orders", () => {
  test("are asked for by what the address says, and as people work at them", () => {
    expect(orders.queryOf({})).toEqual({ sort: "work", descending: false });
    expect(orders.queryOf({ q: "D5", status: "delivered", product: "g2", late: "yes", sort: "due", down: "yes" })).toEqual({
      q: "D5", status: ["delivered"], product: "g2", late: true, sort: "due", descending: true,
    });
    expect(orders.queryOf({ status: "nonsense", sort: "colour", late: "no" })).toEqual({ sort: "work", descending: false });
  });

  test("come as a table of just these", () => {
    expect(orders.tableOf({ status: "open", q: "a b" })).toBe(
      "/api/orders?q=a+b&status=stored&status=released&status=in_production&status=in_delivery&sort=work&descending=false&format=csv",
    );
  });

  test("are asked for within times, and not where these are none", () => {
    const since = "2030-06-01T14:00";
    expect(orders.queryOf({ since, until: "soon" })).toEqual({
      created_since: new Date(since).toISOString(), sort: "work", descending: false,
    });
  });
});

describe("tasks", () => {
  test("are asked for by what the address says, open ones first", () => {
    expect(tasks.queryOf({})).toEqual({ sort: "work", descending: true });
    expect(tasks.queryOf({ state: "withdrawn", kind: "transport", item: "g2", late: "yes", sort: "late", down: "no" })).toEqual({
      state: ["withdrawn"], kind: "transport", item: "g2", late: true, sort: "late", descending: false,
    });
    expect(tasks.tableOf({ q: "ATV3" })).toBe("/api/tasks/history?q=ATV3&sort=work&descending=true&format=csv");
  });
});
