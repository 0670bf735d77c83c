import { describe, expect, test, vi } from "vitest";
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

  test("are asked for by days of the reader, the last one included, and not where these are none", () => {
    const begins = (day: string): string => new Date(`${day}T00:00`).toISOString();
    expect(orders.queryOf({ since: "2030-05-28", until: "2030-05-31" })).toEqual({
      created_since: begins("2030-05-28"), created_before: begins("2030-06-01"), sort: "work", descending: false,
    });
    // An address from before says times, too.
    expect(orders.queryOf({ since: "2030-05-28T14:00", until: "soon" })).toEqual({
      created_since: begins("2030-05-28"), sort: "work", descending: false,
    });
  });

  test("are asked for while a year is still typed, and of no time that the gateway cannot name", () => {
    expect(orders.queryOf({ since: "0002-05-28", until: "9999-12-31" })).toEqual({
      created_since: "1970-01-01T00:00:00.000Z", created_before: "9999-12-31T23:59:59.000Z", sort: "work", descending: false,
    });
    expect(orders.dayOf("0099-05-28")).toBe("1970-01-01T00:00:00.000Z");
    for (const none of ["2030-13-01", "2030-02-30", "2030-00-10", "2030-06-00", "2030-6-3", "soon", "", undefined]) {
      expect(orders.dayOf(none), none).toBeNull();
      expect(orders.dayOf(none, 1), none).toBeNull();
    }
  });

  test.each([
    ["America/Santiago", "2026-09-06", "2026-09-06T04:00:00.000Z", "2026-09-07T03:00:00.000Z"],
    ["Asia/Beirut", "2026-03-29", "2026-03-28T22:00:00.000Z", "2026-03-29T21:00:00.000Z"],
    ["Africa/Cairo", "2026-04-24", "2026-04-23T22:00:00.000Z", "2026-04-24T21:00:00.000Z"],
    ["America/Havana", "2026-03-08", "2026-03-08T05:00:00.000Z", "2026-03-09T04:00:00.000Z"],
    ["Europe/Berlin", "2026-03-29", "2026-03-28T23:00:00.000Z", "2026-03-29T22:00:00.000Z"],
    ["Europe/Berlin", "2026-10-25", "2026-10-24T22:00:00.000Z", "2026-10-25T23:00:00.000Z"],
    ["America/Havana", "2026-11-01", "2026-11-01T04:00:00.000Z", "2026-11-02T05:00:00.000Z"],
  ])("are asked for by whole days where clocks change: in %s on %s", (zone, day, begins, ends) => {
    vi.stubEnv("TZ", zone);
    try {
      expect([orders.dayOf(day), orders.dayOf(day, 1)]).toEqual([begins, ends]);
    } finally {
      vi.unstubAllEnvs();
    }
  });
});

describe("tasks", () => {
  test("are asked for within times, and not where these are none", () => {
    const since = "2030-06-01T14:00";
    expect(tasks.queryOf({ since, until: "soon" })).toEqual({ since: new Date(since).toISOString(), sort: "work", descending: true });
    expect(tasks.queryOf({ since: "0020-06-01T14:00", until: "+275760-09-13T00:00Z" })).toMatchObject({
      since: "1970-01-01T00:00:00.000Z", before: "9999-12-31T23:59:59.000Z",
    });
  });

  test("are asked for by what the address says, open ones first", () => {
    expect(tasks.queryOf({})).toEqual({ sort: "work", descending: true });
    expect(tasks.queryOf({ state: "withdrawn", kind: "transport", item: "g2", late: "yes", sort: "late", down: "no" })).toEqual({
      state: ["withdrawn"], kind: "transport", item: "g2", late: true, sort: "late", descending: false,
    });
    expect(tasks.tableOf({ q: "ATV3" })).toBe("/api/tasks/history?q=ATV3&sort=work&descending=true&format=csv");
  });
});
