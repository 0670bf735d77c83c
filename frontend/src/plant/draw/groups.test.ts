import { expect, test } from "vitest";
import type { AtvView } from "../../api/types";
import type { ShownVehicle } from "../../motion/fleet-motion";
import { lookOf } from "./vehicles";
import { groupsOf, URGENT_LAST } from "./groups";

const vehicle = (id: string, status: AtvView["status"]): ShownVehicle => ({
  view: { id, status } as AtvView, x: 0, y: 0, heading: 0,
});

test("every vehicle is in one group, in the order in which it came", () => {
  const fleet = [vehicle("ATV1", "idle"), vehicle("ATV2", "working"), vehicle("ATV3", "idle"), vehicle("ATV4", "error")];
  const groups = groupsOf(fleet, ({ view }) => lookOf(view, view.id === "ATV2", false));
  const ids = URGENT_LAST.map((look) => groups[look].map(({ view }) => view.id));
  expect(ids).toEqual([[], ["ATV1", "ATV3"], [], [], ["ATV4"], ["ATV2"]]);
});
