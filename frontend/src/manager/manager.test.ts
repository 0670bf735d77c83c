import { describe, expect, test } from "vitest";
import { Problem, problemOf } from "../api/problem";
import type { OrderView, PlantFile, TaskView } from "../api/types";
import { NOTHING, withChosen } from "../selection/selection";
import type { World } from "../stream/world";
import { sparkPoints } from "./cards/factory/spark";
import { firstLook } from "./first-look";
import { placeOf } from "./cards/machine/place";
import { namesOf } from "../plant/names";
import { canBeTakenBack, inOrder, isLate, progressOf, stateOf } from "./orders/progress";
import { problemText } from "./problem-text";
import { checkDraft, chosenOf, type Draft, fieldOf, makersOf, needsOf, orderOf, unableOf } from "./cards/publish/draft";
import { isAskable } from "./cards/publish/preview";
import { taskName } from "./state";
import { addressOf, namedIn, storyOf, viewFrom } from "./views";

const plant = {
  materials: [{ id: "shaft", name: "Shaft", lot: 40 }, { id: "bearing", name: "Bearing", lot: 40 }],
  products: [{ id: "g2", name: "Gear unit G2", bill: [{ material: "shaft", quantity: 1 }, { material: "bearing", quantity: 2 }] }],
  machines: [
    { id: "M1", makes: [{ product: "g2", cycle_s: 54 }] },
    { id: "M2", makes: [{ product: "x", cycle_s: 10 }] },
  ],
  storages: [{ id: "S1", name: "Storage S1", stocks: [{ material: "shaft", capacity: 400 }] }],
  warehouses: [{ id: "OUT", name: "Delivery", kind: "delivery" }],
  chargers: [{ id: "C1" }],
} as unknown as PlantFile;

const order = (more: Partial<OrderView>): OrderView => ({
  id: "O-1", customer: "c", reference: null, status: "released", items: [], created_at_s: 0, due_at_s: null, priority: "normal", wanted_at_s: null,
  delivered_at_s: null, releases: 1, begun: false, revoked_at_s: null, waits: null, changing: false, ...more,
});

describe("a draft", () => {
  const draft: Draft = { product: "g2", quantity: "40", customer: " Nordwerk ", reference: "", due: "", priority: "normal" };

  test("needs a whole number of pieces, a customer and a time to come", () => {
    expect(checkDraft(draft, 0)).toEqual({});
    for (const quantity of ["", "0", "1.5", "-3", "1e3", "100001"]) {
      expect(checkDraft({ ...draft, quantity }, 0)).toEqual({ quantity: "needQuantity" });
    }
    expect(checkDraft({ ...draft, customer: "  " }, 0)).toEqual({ customer: "needCustomer" });
    expect(checkDraft({ ...draft, due: "2001-01-01T10:00" }, 2e9)).toEqual({ due: "needFuture" });
  });

  test("is for the first product until another is chosen, and for none once that one cannot be ordered any more", () => {
    const products = [{ id: "g1" }, { id: "g2" }];
    expect([chosenOf("g2", products), chosenOf("gone", products), chosenOf("", [])]).toEqual(["g2", "", ""]);
    expect(checkDraft({ ...draft, product: "" }, 0)).toEqual({ product: "needProduct" });
  });

  test("can be looked ahead for before it is known who it is for", () => {
    expect(isAskable({ ...draft, customer: "" }, 0)).toBe(true);
    expect(isAskable({ ...draft, quantity: "" }, 0)).toBe(false);
    expect(isAskable({ ...draft, product: "" }, 0)).toBe(false);
    expect(isAskable({ ...draft, due: "2001-01-01T10:00" }, 2e9)).toBe(false);
  });

  test("is sent without what was left empty", () => {
    expect(orderOf(draft, false)).toEqual({
      customer: "Nordwerk", items: [{ product: "g2", quantity: 40 }], priority: "normal", release: false,
    });
    const due = "2030-06-01T14:00";
    expect(orderOf({ ...draft, due, reference: "PO-1" }, true)).toMatchObject({
      due_at: new Date(due).toISOString(), reference: "PO-1", release: true,
    });
  });

  test("knows who makes it and what it needs, in pieces and loads", () => {
    expect(makersOf(plant, "g2")).toEqual([{ id: "M1", cycleS: 54 }]);
    expect(needsOf(plant, "g2", 50)).toEqual([
      { name: "Shaft", pieces: 50, lots: 2 }, { name: "Bearing", pieces: 100, lots: 3 },
    ]);
  });

  test.each([
    ["items.0.quantity", "quantity"],
    ["body/items[0]/product", "product"],
    ["due_at", "due"],
    ["colour", null],
  ])("the gateway's complaint about %s is shown at %s", (field, at) => {
    expect(fieldOf({ field, reason: "", code: "", values: {} })).toBe(at);
  });
});

test("a machine of which nothing was heard yet is not said to be silent or broken", () => {
  const offers = [{ machine: "M1", available: true }, { machine: "M2", available: false }, { machine: "M3", available: false }];
  expect(unableOf(offers, new Map([["M1", 0], ["M2", 0]]))).toEqual({ lost: 1, unheard: 1 });
  expect(unableOf(offers, new Map())).toEqual({ lost: 0, unheard: 2 });
});

describe("a problem", () => {
  test("carries its detail and the fields it is about", () => {
    const problem = problemOf(422, { title: "No", detail: "Not valid", errors: [{ field: "a", reason: "b" }, 7] });
    expect(problem).toMatchObject({ status: 422, message: "Not valid", errors: [{ field: "a", reason: "b" }] });
  });

  test("is readable whatever came instead of an answer", () => {
    expect(problemOf(502, null).message).toBe("HTTP 502");
    expect(problemText(new Problem(0, ""))).toContain("did not answer");
    expect(problemText(new Problem(401, "x"))).toContain("Log in");
  });
});

test("an order is late while it is due and not delivered", () => {
  const late = order({ due_at_s: 50 });
  expect(isLate(late, 100)).toBe(true);
  expect(isLate({ ...late, status: "delivered", delivered_at_s: 40 }, 100)).toBe(false);
  expect(isLate({ ...late, status: "cancelled" }, 100)).toBe(false);
});

describe("orders", () => {
  test("add up over their items", () => {
    const items = [
      { product: "a", quantity: 10, made: 5, delivered: 2, wanted: null }, { product: "b", quantity: 20, made: 20, delivered: 10, wanted: null },
    ];
    expect(progressOf(order({ items }))).toEqual({ quantity: 30, made: 25, delivered: 12 });
  });

  test("stand by due time; without one after those, closed ones last", () => {
    const orders = [
      order({ id: "closed", status: "delivered", delivered_at_s: 1 }), order({ id: "whenever" }),
      order({ id: "later", due_at_s: 9 }), order({ id: "soon", due_at_s: 3 }),
    ];
    expect(inOrder(orders).map(({ id }) => id)).toEqual(["soon", "later", "whenever", "closed"]);
  });
});

describe("choosing", () => {
  test("a vehicle keeps the machine, and the other way round", () => {
    const both = withChosen(withChosen(NOTHING, { kind: "machine", id: "M1" }), { kind: "atv", id: "ATV1" });
    expect(both).toMatchObject({ atv: "ATV1", place: { id: "M1" }, latest: "atv" });
  });

  test("something else lets a task go", () => {
    const task = withChosen(NOTHING, { kind: "task", id: "T" });
    expect(withChosen(task, { kind: "atv", id: "ATV1" }).task).toBeNull();
  });

  test("begins with the transport under way for which most have bid, the newest of these", () => {
    const transport = (opened_at_s: number, primary: string, ...bidders: string[]) => ({
      id: `T${opened_at_s}`, opened_at_s, state: "contracted", coordinator: "M1", primary,
      bids: bidders.map((bidder) => ({ bidder, role: "primary", epoch: 1, round: 1, total_s: 1 })),
    }) as unknown as TaskView;
    const tasks = [
      transport(1, "ATV1", "ATV1", "ATV2"), transport(2, "ATV2", "ATV1", "ATV2"),
      transport(3, "ATV1", "ATV1"), transport(4, "gone", "ATV1", "ATV2", "gone"),
    ];
    const world = {
      tasks: new Map(tasks.map((task) => [task.id, task])),
      atvs: new Map([["ATV1", {}], ["ATV2", {}]]), machines: new Map([["M1", {}]]),
    } as unknown as World;
    expect(firstLook(world)).toMatchObject({ atv: "ATV2", place: { id: "M1" } });
    expect(firstLook({ ...world, tasks: new Map() })).toBeNull();
  });
});

test("a sparkline begins at zero and ends at the right edge", () => {
  expect(sparkPoints([0, 5, 10], 100, 20)).toEqual([[0, 20], [50, 10], [100, 0]]);
  expect(sparkPoints([], 100, 20)).toEqual([]);
  expect(sparkPoints([0, 0], 100, 20)[1]).toEqual([100, 20]);
});

test("ids have names, and are their own where they have none", () => {
  expect(namesOf(plant)("g2")).toBe("Gear unit G2");
  expect(namesOf(null)("g2")).toBe("g2");
});

test("places are known by what they are", () => {
  expect(placeOf(plant, "S1")?.kind).toBe("storage");
  expect(placeOf(plant, "OUT")?.kind).toBe("delivery");
  expect(placeOf(plant, "C1")?.kind).toBe("charger");
  expect(placeOf(plant, "M1")).toBeNull();
});

test("an address that is no view leads to the plant", () => {
  expect(viewFrom("#orders")).toBe("orders");
  expect(viewFrom("#nonsense")).toBe("plant");
});

test("an order has an address of its own", () => {
  expect(viewFrom("#orders/O-1")).toBe("orders");
  expect(namedIn("#orders/O-1", "orders")).toBe("O-1");
  expect(namedIn("#orders", "orders")).toBe("");
  expect(namedIn("#tasks/O-1", "orders")).toBe("");
  expect(namedIn(addressOf("a/b c%"), "orders")).toBe("a/b c%");
  expect(namedIn("#orders/%E0%A4%A", "orders")).toBe("%E0%A4%A");
});

test("a task leads to where its story is told", () => {
  const called = "T-1M9K3X2A4-K7QM";
  expect(storyOf({ id: `${called}-2`, kind: "transport", order: "" })).toBe(`#transports/${called}`);
  expect(storyOf({ id: "M4.1-3", kind: "transport", order: "O-1" })).toBe("#orders/O-1?transport=M4.1-3");
  expect(storyOf({ id: "G-1", kind: "production", order: "O-1" })).toBe("#orders/O-1");
  expect(storyOf({ id: "M4.1-3", kind: "transport", order: "" })).toBe("#transports/M4.1-3");
  expect(storyOf({ id: "G-1", kind: "production", order: "" })).toBe("");
});

describe("an order that is taken back", () => {
  test("is so only when the factory has confirmed it", () => {
    expect(stateOf(order({ status: "in_production", begun: true }))).toBe("in_production");
    expect(stateOf(order({ status: "in_production", revoked_at_s: 5 }))).toBe("being_taken_back");
    expect(stateOf(order({ status: "stored", revoked_at_s: 5 }))).toBe("taken_back");
    expect(stateOf(order({ status: "stored", releases: 0 }))).toBe("stored");
    expect(stateOf(order({ status: "cancelled", revoked_at_s: 5 }))).toBe("cancelled");
  });

  test("is planned until a machine works at it", () => {
    expect(stateOf(order({ status: "in_production" }))).toBe("planned");
    expect(stateOf(order({ status: "in_production", revoked_at_s: 5 }))).toBe("being_taken_back");
    expect(stateOf(order({ status: "in_delivery" }))).toBe("in_delivery");
  });

  test("was in work, and nobody had asked before", () => {
    expect(canBeTakenBack(order({ status: "released" }))).toBe(true);
    for (const more of [{ status: "stored" }, { status: "delivered" }, { revoked_at_s: 5 }] as const) {
      expect(canBeTakenBack(order(more))).toBe(false);
    }
  });
});

describe("a task", () => {
  test.each([
    ["O-1M8-4.2", "O-1M8", "D5", "D5-4.2"],
    ["O-1M8-4.2", "O-1M8", "O-1M8", "O-1M8-4.2"],
    ["M8.1-2", "O-1M8", "D5", "M8.1-2"],
    ["M8.1-2", "", "", "M8.1-2"],
  ])("%s of the order %s, which is called %s, is %s", (id, ofOrder, called, name) => {
    expect(taskName(id, ofOrder, called)).toBe(name);
  });
});
