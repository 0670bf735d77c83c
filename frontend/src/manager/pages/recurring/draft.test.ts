import { describe, expect, test } from "vitest";
import type { Schedule } from "../../../api/schedules";
import { calendarOf, coming, dayName, daysOff, draftOf, empty, partOf, shown, writtenOf } from "./draft";

const schedule: Schedule = {
  id: "S-1", etag: '"1-0-0"', name: "Shafts", calendar: "45 5 * * 1,2,3", time_zone: "Europe/Berlin", holidays: ["2030-12-25"], holidays_of: "DE-BW", skipped: [],
  missed: "catch_up", paused: false, owner_gone: false, transport: { from: "S3", to: "M8", item: "shaft", thing: null, quantity: 40, priority: "high", vehicle: "ATV3", vehicle_only: false, ability: "pallet" },
  order: null,
  next_runs: [], last: null, missed_at: null, changed_by: "Mia", changed_at: "2030-01-01T00:00:00.000Z",
};

describe("a calendar", () => {
  test.each([
    [{ days: ["0", "5"], time: "06:05" }, "5 6 * * 5,0"],
    [{ days: [] }, "0 6 * * *"],
    [{ days: ["0", "1", "2", "3", "4", "5", "6"] }, "0 6 * * *"],
    [{ cron: " */30 * * * * ", time: "06:05" }, "*/30 * * * *"],
  ])("of %j is %s", (change, cron) => {
    expect(calendarOf({ ...empty("UTC"), ...change })).toBe(cron);
  });

  test.each([
    ["0 6 * * MON-SAT", ["1", "2", "3", "4", "5", "6"]],
    ["05 16 * * 5-7", ["5", "6", "0"]],
    ["0 6 * * sun", ["0"]],
    ["0 6 * * 0-6", ["1", "2", "3", "4", "5", "6", "0"]],
  ])("%s ticks exactly its days, and no field of cron's", (calendar, days) => {
    const written = writtenOf({ ...schedule, calendar });
    expect([written.days, written.cron]).toEqual([days, ""]);
  });

  test.each(["*/30 * * * *", "0 6 1 * *", "0 6 * 1 MON", "0 6,18 * * MON-SAT", "0 6 L * *"])("that days do not tell, %s, stands in cron's field, and ticks none", (calendar) => {
    const written = writtenOf({ ...schedule, calendar });
    expect([written.days, written.cron]).toEqual([[], calendar]);
  });

  test("of which a day was ticked off is told by the days that are left", () => {
    const written = writtenOf({ ...schedule, calendar: "30 6 * * MON-SAT" });
    expect(calendarOf({ ...written, days: written.days.slice(1) })).toBe("30 6 * * 2,3,4,5,6");
    expect(calendarOf({ ...written, time: "07:30" })).toBe("30 7 * * 1,2,3,4,5,6");
  });

  test.each(["45 5 * * 1,2,3", "0 22 * * *", "*/30 * * * *", "0 6 1 * *", "0 6 * * MON-FRI", "0 6 * * MON-SAT", "05 06 * * 5-7"])("of %s comes back as it was", (calendar) => {
    expect(calendarOf(writtenOf({ ...schedule, calendar }))).toBe(calendar);
  });
});

test("what is there is sent as it was", () => {
  const { calendar, holidays, holidays_of, missed, name, time_zone, transport } = schedule;
  expect(draftOf(writtenOf(schedule))).toEqual({ calendar, holidays, holidays_of, missed, name, time_zone, transport });
});

test("an order is sent as it was", () => {
  const order = { customer: "Hall 3", reference: "weekly", items: [{ product: "P1", quantity: 20 }, { product: "P2", quantity: 1 }], priority: "urgent", due_after_s: 5400 };
  const written = writtenOf({ ...schedule, transport: null, order });
  expect([written.kind, written.dueH]).toEqual(["order", "1.5"]);
  expect(draftOf(written).order).toEqual(order);
  expect(draftOf(written).transport).toBeUndefined();
  expect(draftOf({ ...written, dueH: " ", reference: "" }).order).toMatchObject({ due_after_s: null, reference: null });
  expect(draftOf({ ...written, dueH: "2,5" }).order?.due_after_s).toBe(9000);
  expect(draftOf({ ...written, dueH: "soon" }).order?.due_after_s).toBe("soon");
});

test("what is no number goes as it was written", () => {
  expect(draftOf({ ...empty("UTC"), quantity: "many", holidays: "2030-01-01,\n2030-01-06" })).toMatchObject({
    holidays: ["2030-01-01", "2030-01-06"],
    transport: { quantity: "many", from: null },
  });
});

test.each([["calendar", "cron"], ["holidays[3]", "holidays"], ["holidays_of", "holidaysOf"], ["transport.item", "item"], ["transport.ability", "ability"], ["transport.source", ""], ["paused", ""], ["order.items[2].product", "line.2"], ["order.items", "lines"], ["order.due_after_s", "dueH"], ["order.customer", "customer"]])(
  "a complaint about %s stands at %j", (field, part) => { expect(partOf(field)).toBe(part); },
);

test("a moment is told by the clock of its zone", () => {
  expect(shown("2030-03-18T06:00:00+01:00", "Europe/Berlin", "en")).toContain("06:00");
  expect(dayName("1", "de")).toBe("Mo");
});

test("days off that are past are not named, and of many the next ones", () => {
  expect(daysOff(["2026-12-26", "2026-11-01", "2026-12-25"], "2026-11-30", "en")).toEqual(["25 Dec 2026", "26 Dec 2026"]);
  expect(daysOff(["2026-12-24", "2026-12-25", "2026-12-26", "2027-01-01", "2027-01-06"], "2026-12-24", "en")).toEqual(["24 Dec 2026", "25 Dec 2026", "26 Dec 2026", "+2"]);
  expect(daysOff([], "2026-11-30", "en")).toEqual([]);
});

test("a skipped moment that is past can be skipped no more", () => {
  expect(coming(["2026-11-30T15:00:00+01:00", "2026-11-30T15:10:00+01:00"], Date.parse("2026-11-30T14:00:00Z"))).toEqual(["2026-11-30T15:10:00+01:00"]);
});
