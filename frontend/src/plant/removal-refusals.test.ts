import { expect, test } from "vitest";
import type { AtvView } from "../api/types";
import { refusalsOf } from "./removal-refusals";

type Refused = NonNullable<AtvView["removal"]>["refused"];

const refused: Refused = [
  { agent: "", reason: "is_heard", text: "" },
  { agent: "M3", reason: "heard_since", text: "" },
  { agent: "M4", reason: "is_heard", text: "" },
  { agent: "M5", reason: "heard_since", text: "" },
  { agent: "", reason: "is_heard", text: "" },
];

const atv = (freed: string[], holds = ["b3", "c3"], node = "", kept = false): Pick<AtvView, "holds" | "removal"> => ({
  holds,
  removal: { number: 1, by: "Anna", at_s: 0, believed_at_s: 0, node, freed, kept, refused },
});

test("machines that refuse a report for the same reason are named together, those elsewhere once", () => {
  expect([...refusalsOf(atv([]))]).toEqual([["heard_since", ["M3", "M5"]], ["is_heard", ["M4", ""]]]);
});

test("a machine that refuses it is told as long as one of the places is not free", () => {
  expect(refusalsOf(atv(["b3"])).size).toBe(2);
  expect(refusalsOf(atv(["b3", "c3", "d3"])).size).toBe(0);
});

test("a machine that does not keep the place where the vehicle is put back is told until it is kept", () => {
  expect(refusalsOf(atv(["b3", "c3"], ["b3"], "p1")).size).toBe(2);
  expect(refusalsOf(atv(["b3", "c3"], ["b3"], "p1", true)).size).toBe(0);
});

test("it is told of a name whose places nobody has heard", () => {
  expect(refusalsOf(atv([], [])).size).toBe(2);
  expect(refusalsOf(atv(["b3"], [])).size).toBe(0);
});

test("a vehicle on the floor is refused nothing", () => {
  expect(refusalsOf({ holds: ["b3"], removal: null }).size).toBe(0);
});
