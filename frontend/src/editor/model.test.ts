import { describe, expect, test } from "vitest";
import { begin, redo, step, undo } from "./history";
import * as model from "./model";

const DATA: model.Data = {
  nodes: [{ id: "a", x_m: 0, y_m: 0 }, { id: "b", x_m: 10, y_m: 0 }],
  lanes: [{ start: "a", end: "b", both_ways: true }],
  machines: [{ id: "M1", name: "Lathe", node: "b", box: { x_m: 10, y_m: 2, width_m: 2, depth_m: 1 } }],
  storages: null,
};

describe("drawing", () => {
  test("a node is taken where there is one, and made where there is none", () => {
    expect(model.withNode(DATA, { x_m: 0.2, y_m: 0 }, 0.5)).toEqual([DATA, "a"]);
    const [next, id] = model.withNode(DATA, { x_m: 5, y_m: 5 }, 0.5);
    expect(id).toBe("n1");
    expect(model.nodesOf(next)).toHaveLength(3);
  });

  test("a second lane between two nodes, or one to itself, is none", () => {
    expect(model.withLane(DATA, "b", "a", false)).toBe(DATA);
    expect(model.withLane(DATA, "a", "a", true)).toBe(DATA);
  });

  test("a new place leaves open what nobody has said", () => {
    const next = model.withPlace(DATA, "storages", { x_m: 0, y_m: 0 }, 0.5);
    expect(next.storages).toEqual([{ id: "S1", name: "S1", node: "a", box: { x_m: 1, y_m: 1.5, width_m: 2, depth_m: 1.5 }, stocks: null }]);
  });

  test("the box of a new dock stands inside the floor, wherever the dock is", () => {
    const floor = { width_m: 20, height_m: 10 };
    const box = (x_m: number, y_m: number) => model.boxBeside(floor, { x_m, y_m });
    expect(box(10, 5)).toEqual({ x_m: 10, y_m: 6.5, width_m: 2, depth_m: 1.5 });
    expect(box(10, 9.5)).toEqual({ x_m: 10, y_m: 8, width_m: 2, depth_m: 1.5 });
    expect(box(0, 5)).toEqual({ x_m: 1, y_m: 6.5, width_m: 2, depth_m: 1.5 });
    for (const x_m of [-3, 0, 0.4, 10, 19.6, 20, 25]) {
      for (const y_m of [-3, 0, 0.4, 5, 9.6, 10, 14]) {
        const { depth_m, width_m, ...at } = box(x_m, y_m);
        expect(at.x_m - width_m / 2).toBeGreaterThanOrEqual(0);
        expect(at.x_m + width_m / 2).toBeLessThanOrEqual(20);
        expect(at.y_m - depth_m / 2).toBeGreaterThanOrEqual(0);
        expect(at.y_m + depth_m / 2).toBeLessThanOrEqual(10);
      }
    }
  });

  test("a node takes its docks' boxes along, and its name is changed wherever it is meant", () => {
    const next = model.moved(DATA, { section: "nodes", index: 1 }, { x_m: 12, y_m: 1 });
    expect(model.entries<model.Place>(next, "machines")[0]?.box).toEqual({ x_m: 12, y_m: 3, width_m: 2, depth_m: 1 });
    const named = model.changed(DATA, { section: "nodes", index: 1 }, { id: "east" });
    expect(model.lanesOf(named)[0]?.end).toBe("east");
    expect(model.entries<model.Place>(named, "machines")[0]?.node).toBe("east");
    expect(named.storages).toBe(null);
  });

  test("a repair adds an entry, changes one, or takes one away", () => {
    const joined = model.repaired(DATA, { section: "lanes", index: null, entry: { start: "b", end: "c" }, also: [] });
    expect(model.lanesOf(joined)).toHaveLength(2);
    const back = model.repaired(joined, { section: "lanes", index: 1, entry: { both_ways: true }, also: [] });
    expect(model.lanesOf(back)[1]).toEqual({ start: "b", end: "c", both_ways: true });
    expect(model.lanesOf(model.repaired(back, { section: "lanes", index: 0, entry: null, also: [] }))).toEqual([{ start: "b", end: "c", both_ways: true }]);
  });

  test("a repair moves what goes along with a node", () => {
    const apart = model.repaired(DATA, { section: "nodes", index: 0, entry: { x_m: 3 }, also: [{ index: 1, entry: { x_m: 13 } }] });
    expect(model.nodesOf(apart).slice(0, 2).map(({ x_m }) => x_m)).toEqual([3, 13]);
  });

  test("a node goes with its lanes, and with what was closed of them", () => {
    const closed = model.closedOrNot(DATA, 0);
    expect(model.isClosed(closed, { start: "a", end: "b" })).toBe(true);
    expect(model.closedOrNot(closed, 0).closed).toEqual([]);
    const next = model.removed(closed, { section: "nodes", index: 0 });
    expect([model.lanesOf(next), next.closed]).toEqual([[], []]);
  });

  test("what is no door, or stands on no lane, is left as it is", () => {
    const odd = { ...DATA, doors: [null, "none", { id: "D1" }, { id: "D2", lanes: [null, { start: "b", end: "a" }] }] };
    expect(model.doorAt(odd, { start: "a", end: "b" })).toBe(3);
    expect(model.doorAt(odd, { start: "b", end: "c" })).toBe(-1);
    expect(model.spotOf(odd, { section: "doors", index: 0 })).toBeNull();
    expect(model.spotOf(odd, { section: "doors", index: 2 })).toBeNull();
    expect(model.changed(odd, { section: "nodes", index: 0 }, { id: "east" }).doors).toEqual([null, "none", { id: "D1" }, { id: "D2", lanes: [null, { start: "b", end: "east" }] }]);
    expect(model.doorOrNot(odd, 0).doors).toEqual([null, "none", { id: "D1" }, { id: "D2", lanes: [null] }]);
    expect(model.freeId(odd, "D", "doors")).toBe("D3");
  });

  test("a door is put on a lane and taken away, keeps to nodes that are renamed, and goes with its lane", () => {
    const shut = model.doorOrNot(DATA, 0);
    expect(shut.doors).toEqual([{ id: "D1", name: "D1", lanes: [{ start: "a", end: "b" }], opening_s: 8, closes_after_s: 5 }]);
    expect(model.hasDoor(shut, { start: "b", end: "a" })).toBe(true);
    expect(model.doorOrNot(shut, 0).doors).toEqual([]);
    const named = model.changed(shut, { section: "nodes", index: 1 }, { id: "east" });
    expect(model.entries<model.Door>(named, "doors")[0]?.lanes).toEqual([{ start: "a", end: "east" }]);
    expect(model.removed(shut, { section: "lanes", index: 0 }).doors).toEqual([]);
    expect(model.removed(shut, { section: "nodes", index: 0 }).doors).toEqual([]);
    expect(model.moved(shut, { section: "nodes", index: 1 }, { x_m: 12, y_m: 1 }).doors).toEqual(shut.doors);
  });

  test("a station that is said to be a machine is one, with the rest of it open", () => {
    const data = { ...DATA, unassigned: [{ id: "U1", name: "Press", node: "a", original: "7.1" }] };
    const next = model.assigned(data, 0, "machines");
    expect(next.unassigned).toEqual([]);
    expect(model.entries(next, "machines")[1]).toMatchObject({ id: "U1", name: "Press", node: "a", makes: null, station: null, original: "7.1" });
    expect(model.entries(model.assigned(data, 0, "parkings"), "parkings").at(-1)).toEqual({ id: "U1", node: "a", original: "7.1" });
    const plain = { ...DATA, unassigned: [{ id: "U1", name: "Press", node: "a" }] };
    expect(model.entries(model.assigned(plain, 0, "parkings"), "parkings").at(-1)).toEqual({ id: "U1", node: "a" });
  });
});

describe("a draft of any shape", () => {
  test("is looked at without harm", () => {
    const odd: model.Data = { nodes: [null, { id: 3 }, { id: "a", x_m: "1", y_m: 0 }], lanes: "none", machines: [null, 3] };
    expect(model.nodesOf(odd)).toEqual([]);
    expect(model.places(odd)).toEqual([]);
    expect(model.lanesOf(odd)).toEqual([]);
  });

  test("findings lead to what they are about", () => {
    expect(model.chosenOf("machines[3].node")).toEqual({ section: "machines", index: 3 });
    expect(model.chosenOf("materials")).toBe(null);
    expect(model.chosenOf("vehicle_types[0].length_m")).toBe(null);
  });

  test("the lane that runs nearest is found anywhere along it, and along its shape", () => {
    expect(model.nearestLane(DATA, { x_m: 9, y_m: 0.5 }, 1.5)).toBe(0);
    expect(model.nearestLane(DATA, { x_m: 5, y_m: 2 }, 1.5)).toBe(-1);
    expect(model.nearestLane(DATA, { x_m: 12, y_m: 0 }, 1.5)).toBe(-1);
    const bent = { ...DATA, lanes: [{ start: "a", end: "b", shape: [{ x_m: 5, y_m: 8 }] }, { start: "b", end: "c" }] };
    expect(model.nearestLane(bent, { x_m: 5, y_m: 7.5 }, 1.5)).toBe(0);
    expect(model.nearestLane(bent, { x_m: 5, y_m: 0 }, 1.5)).toBe(-1);
  });

  test("differences from the running plant are counted once each", () => {
    expect(model.differences(DATA, DATA)).toBe(0);
    expect(model.differences(model.changed(DATA, { section: "nodes", index: 0 }, { x_m: 1 }), DATA)).toBe(1);
    expect(model.differences(model.removed(DATA, { section: "machines", index: 0 }), DATA)).toBe(1);
  });
});

test("what was drawn is undone and done again", () => {
  let history = begin(1);
  history = step(step(history, 2), 3);
  expect(undo(history).now).toBe(2);
  expect(redo(undo(history)).now).toBe(3);
  expect(undo(undo(undo(history))).now).toBe(1);
  expect(redo(step(undo(history), 9)).now).toBe(9);
});

test("an empty floor is a plant file whose sections are open, with an id of its name", () => {
  const begins = (name: string): string[] => model.emptyFloor(name, 40, 25).split("\n").slice(0, 6);
  expect(begins("Halle “4”")).toEqual(["plant: halle-4", 'name: "Halle “4”"', "width_m: 40", "height_m: 25", "nodes: []", "lanes: []"]);
  expect(begins("4.")[0]).toBe("plant: plant");
  expect(begins("x".repeat(40))[0]).toBe(`plant: ${"x".repeat(32)}`);
  expect(model.emptyFloor("a", 1, 1)).toContain("machines: null\n");
});
