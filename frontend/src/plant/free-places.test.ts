import { expect, test } from "vitest";
import type { PlantFile } from "../api/types";
import { freePlaces } from "./free-places";

const plant = {
  nodes: [{ id: "n1", x_m: 0, y_m: 0 }, { id: "n2", x_m: 10, y_m: 0 }, { id: "n3", x_m: 20, y_m: 0 }],
  parkings: [{ id: "P1", node: "n1" }, { id: "P2", node: "n2" }],
  chargers: [{ id: "C1", node: "n3" }],
} as unknown as PlantFile;
const me = { id: "ATV1", x_m: 18, y_m: 0 };
const other = (node: string, more: object = {}) => ({ id: "ATV2", node, holds: [], removal: null, ...more });

test("the place nearest to where a vehicle stood comes first", () => {
  expect(freePlaces(plant, [], me)).toEqual(["C1", "P2", "P1"]);
});

test("a place where another vehicle stands or is about to be is not offered", () => {
  expect(freePlaces(plant, [other("n2")], me)).toEqual(["C1", "P1"]);
  expect(freePlaces(plant, [other("n9", { holds: ["n3"] })], me)).toEqual(["P2", "P1"]);
});

test("what was carried away holds nothing, and nobody is in its own way", () => {
  const removal = { number: 1, by: "Anna", at_s: 0, believed_at_s: 0, node: "", freed: [], kept: false };
  expect(freePlaces(plant, [other("n2", { removal }), { ...other("n3"), id: "ATV1" }], me)).toEqual(["C1", "P2", "P1"]);
});

test("without a plan there is no place", () => {
  expect(freePlaces(null, [], me)).toEqual([]);
});
