import { expect, test } from "vitest";
import { complaintsOf, draftOf, EMPTY, loadsOf, loadsText, mostOf } from "./call";
import { queryOf, tableOf } from "./filter";

test.each([
  [{}, {}],
  [{ state: "open" }, { status: ["waiting", "assigned", "on_board"] }],
  [{ state: "delivered", place: "M8" }, { status: ["delivered"], place: "M8" }],
  [{ state: "eaten" }, {}],
  [{ q: "bearing M8" }, { q: "bearing M8" }],
])("the address %j asks for %j", (said, query) => { expect(queryOf(said)).toEqual({ ...query, sort: "called", descending: true }); });

test("the address says in which order they come, in the list and in the table", () => {
  expect(queryOf({ sort: "due", down: "no" })).toEqual({ sort: "due", descending: false });
  expect(queryOf({ sort: "colour" }).sort).toBe("called");
  expect(tableOf({ sort: "due", down: "no", state: "open" })).toBe("/api/transports?status=waiting&status=assigned&status=on_board&sort=due&descending=false&format=csv");
});

test("what is left empty is left to the gateway, and what is no number it refuses", () => {
  expect(draftOf({ ...EMPTY, item: "shaft", quantity: " 40 ", to: "M8" })).toEqual({
    from: null, to: "M8", item: "shaft", thing: null, quantity: 40, priority: "normal", vehicle: null, vehicle_only: true, ability: null, due_at: null, not_before: null,
  });
  expect(draftOf({ ...EMPTY, begin: "2030-01-01T10:00" }).not_before).toBe(new Date("2030-01-01T10:00").toISOString());
  expect(draftOf({ ...EMPTY, quantity: "many" }).quantity).toBe("many");
  expect(draftOf({ ...EMPTY, thing: " pump housing ", from: "M8", to: "S5", ability: "tote" })).toMatchObject({ item: null, thing: "pump housing", quantity: null });
});

test("a complaint stands at its field", () => {
  expect(complaintsOf([{ field: "due_at", reason: "past" }, { field: "not_before", reason: "late" }, { field: "colour", reason: "none" }])).toEqual({ at: { due: "past", begin: "late" }, elsewhere: "colour: none" });
});

test("what is more than one load comes in several, with what is left in the last", () => {
  expect(loadsOf(100, 40)).toEqual([40, 40, 20]);
  expect(loadsOf(80, 40)).toEqual([40, 40]);
  expect([loadsText(100, 40), loadsText(80, 40)]).toEqual(["2 x 40 + 20", "2 x 40"]);
  const tooLarge = { field: "quantity", reason: "more", code: "load_too_large", values: { most: "40" } };
  expect(mostOf([tooLarge])).toBe(40);
  expect(mostOf([tooLarge, { field: "to", reason: "unknown", code: "place_not_keeping", values: {} }])).toBe(0);
});
