import { describe, expect, test } from "vitest";
import { LABEL, NUMBER, labelPlaces, marksOf, nameBelow } from "./marks";

const covers = (label: { x: number; y: number }, number: { x: number; y: number }): boolean =>
  Math.abs(label.x - number.x - NUMBER.x) < LABEL.width / 2 + NUMBER.r && Math.abs(label.y - number.y - NUMBER.y) < LABEL.height / 2 + NUMBER.r;

describe("the label of a measure", () => {
  test("lies below it where nothing is", () => {
    expect(labelPlaces([{ x: 100, y: 100 }], [])).toEqual([{ x: 0, y: 17 }]);
  });

  test("covers no number, wherever that is", () => {
    for (let x = -40; x <= 40; x += 4) {
      for (let y = -40; y <= 60; y += 4) {
        const number = { x: 100 + x, y: 100 + y };
        const [place] = labelPlaces([{ x: 100, y: 100 }], [number]);
        expect(covers({ x: 100 + (place?.x ?? 0), y: 100 + (place?.y ?? 0) }, number)).toBe(false);
      }
    }
  });

  test("covers no other label of the same place", () => {
    const places = labelPlaces(Array.from({ length: 6 }, () => ({ x: 0, y: 0 })), []);
    expect(new Set(places.map(({ x, y }) => `${x} ${y}`)).size).toBe(6);
  });
});

describe("the name of a place", () => {
  const box = { x_m: 0, y_m: 0, width_m: 4, depth_m: 3 };

  test("stands in its box as long as it fits", () => {
    expect(nameBelow("SAW", box, 1)).toBeLessThan(box.depth_m / 2);
    expect(nameBelow("CHARGER", box, 1)).toBeGreaterThanOrEqual(box.depth_m / 2 + 1);
    expect(nameBelow("CHARGER", box, 0.5)).toBeLessThan(box.depth_m / 2);
  });

  test("stands below its node where it has no box yet", () => {
    expect(nameBelow("IN", null, 0.5)).toBe(1);
    expect(nameBelow("IN", undefined, 2)).toBe(2.5);
  });
});

test("each thing has the number of its first finding", () => {
  const data = { nodes: [{ id: "a", x_m: 1, y_m: 2 }] };
  const found = marksOf([{ field: "machines" }, { field: "nodes[0].x_m" }, { field: "nodes[0]" }, { field: "nodes[7]" }], data);
  expect(found).toEqual([{ key: "nodes[0]", number: 2, spot: data.nodes[0] }]);
});
