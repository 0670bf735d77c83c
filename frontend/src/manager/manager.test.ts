import { describe, expect, test } from "vitest";
import { Problem, problemOf } from "../api/client";
import type { AtvView, FactoryView, MachineView, OrderView, PlantFile, TaskView } from "../api/types";
import { NOTHING, withChosen } from "../selection/selection";
import type { World } from "../stream/world";
import { alertsOf, isLate } from "./alerts/alerts";
import { sparkPoints } from "./factory/spark";
import { firstLook } from "./first-look";
import { placeOf } from "./machine/place";
import { namesOf } from "../plant/names";
import { inOrder, progressOf } from "./orders/progress";
import { problemText } from "./problem-text";
import { checkDraft, type Draft, fieldOf, makersOf, needsOf, orderOf } from "./publish/draft";
import { viewFrom } from "./views";

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
  id: "O-1", customer: "c", reference: null, status: "released", items: [], created_at_s: 0, due_at_s: null,
  delivered_at_s: null, releases: 1, revoked_at_s: null, waits: "", ...more,
});

describe("a draft", () => {
  const draft: Draft = { product: "g2", quantity: "40", customer: " Nordwerk ", reference: "", due: "" };

  test("needs a whole number of pieces, a customer and a time to come", () => {
    expect(checkDraft(draft, 0)).toEqual({});
    for (const quantity of ["", "0", "1.5", "-3", "1e3", "100001"]) {
      expect(checkDraft({ ...draft, quantity }, 0)).toEqual({ quantity: "needQuantity" });
    }
    expect(checkDraft({ ...draft, customer: "  " }, 0)).toEqual({ customer: "needCustomer" });
    expect(checkDraft({ ...draft, due: "2001-01-01T10:00" }, 2e9)).toEqual({ due: "needFuture" });
  });

  test("is sent without what was left empty", () => {
    expect(orderOf(draft, false)).toEqual({
      customer: "Nordwerk", items: [{ product: "g2", quantity: 40 }], release: false,
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
    expect(fieldOf({ field, reason: "" })).toBe(at);
  });
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

describe("alerts", () => {
  const machine = (id: string, status: MachineView["status"], more: Partial<MachineView> = {}) =>
    ({ id, status, problem: "spindle", seen_at_s: 100, ...more }) as MachineView;
  const atv = (id: string, more: Partial<AtvView>) =>
    ({ id, status: "idle", seen_at_s: 100, battery_frac: 0.9, problem: "", ...more }) as AtvView;
  const world = (atvs: AtvView[], machines: MachineView[], orders: OrderView[] = []): World => ({
    number: 1, atS: 100, plant: "p", factory: { speed: 1 } as FactoryView, tasks: new Map(), news: new Map(), trials: false, faults: new Map(),
    atvs: new Map(atvs.map((each) => [each.id, each])),
    machines: new Map(machines.map((each) => [each.id, each])),
    orders: new Map(orders.map((each) => [each.id, each])),
  });

  test("put alarms before warnings, and leave out what is normal", () => {
    const alerts = alertsOf(
      world([atv("ATV1", {}), atv("ATV2", { status: "stopped" })], [machine("M1", "starved"), machine("M2", "error"), machine("M3", "producing")]),
      100,
    );
    expect(alerts.map(({ level, subject }) => [level, subject])).toEqual([
      ["alarm", "M2"], ["warning", "M1"], ["warning", "ATV2"],
    ]);
  });

  test("say of a silent vehicle that it is silent, whatever it said last", () => {
    const [alert] = alertsOf(world([atv("ATV1", { status: "error", seen_at_s: 40 })], []), 100);
    expect(alert).toMatchObject({ reason: "atvLost", value: 60 });
  });

  test("say of a silent machine that it is silent", () => {
    const [alert] = alertsOf(world([], [machine("M1", "producing", { seen_at_s: 70 })]), 100);
    expect(alert).toMatchObject({ reason: "machineLost", value: 30, level: "alarm" });
  });

  test("ask for help with the time that is left, and warn only once somebody comes", () => {
    const help = { until_at_s: 142, promised_by: "" };
    const needs = atv("ATV1", { status: "error", help });
    expect(alertsOf(world([needs], []), 100)[0]).toMatchObject({ level: "alarm", reason: "atvHelp", value: 42 });
    const promised = { ...needs, help: { ...help, promised_by: "Hall 1" } };
    expect(alertsOf(world([promised], []), 100)[0]).toMatchObject({ level: "warning", reason: "atvPromised", by: "Hall 1" });
  });

  test("tell of a task's trouble, unless its carrier tells of it itself", () => {
    const task = { id: "M8-3", primary: "ATV1", trouble: "blocked" } as TaskView;
    const of = (problem: string) => alertsOf({ ...world([atv("ATV1", { problem })], []), tasks: new Map([["M8-3", task]]) }, 100);
    expect(of("").map(({ reason }) => reason)).toEqual(["taskTrouble"]);
    expect(of("blocked")).toEqual([]);
  });

  test("say why an order waits, rather than that it is late", () => {
    const waits = order({ due_at_s: 50, waits: "no machine can make it" });
    expect(alertsOf(world([], [], [waits]), 100)).toMatchObject([{ reason: "orderWaits", problem: "no machine can make it" }]);
  });

  test("name late orders, but none that is delivered in time or cancelled", () => {
    const late = order({ due_at_s: 50 });
    expect(isLate(late, 100)).toBe(true);
    expect(isLate({ ...late, status: "delivered", delivered_at_s: 40 }, 100)).toBe(false);
    expect(isLate({ ...late, status: "cancelled" }, 100)).toBe(false);
    expect(alertsOf(world([], [], [late]), 100)[0]?.reason).toBe("orderLate");
  });
});

describe("orders", () => {
  test("add up over their items", () => {
    const items = [
      { product: "a", quantity: 10, made: 5, delivered: 2 }, { product: "b", quantity: 20, made: 20, delivered: 10 },
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

  test("begins with the newest carriage under way", () => {
    const carriage = (id: string, opened_at_s: number) =>
      ({ id, opened_at_s, state: "contracted", coordinator: "M1", primary: "ATV1" }) as TaskView;
    const world = {
      tasks: new Map([["1", carriage("1", 1)], ["2", { ...carriage("2", 2), primary: "gone" }]]),
      atvs: new Map([["ATV1", {}]]), machines: new Map([["M1", {}]]),
    } as unknown as World;
    expect(firstLook(world)).toMatchObject({ atv: "ATV1", place: { id: "M1" } });
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
