import { expect, test } from "vitest";
import type { AtvView } from "../../api/types";
import { KEPT_MS } from "../stop/places";
import { stayed } from "./staying";

const atv = (id: string): AtvView => ({ id }) as AtvView;
const present = (...ids: string[]): Map<string, AtvView> => new Map(ids.map((id) => [id, atv(id)]));
const NONE = new Set<string>();

test("whoever has left stays while a hand may be over its card, and no longer", () => {
  const here = stayed(new Map(), present("ATV5", "ATV7"), NONE, 0);
  const left = stayed(here, present("ATV7"), NONE, 100);
  expect(left.get("ATV5")).toEqual({ atv: atv("ATV5"), atMs: 100 });
  expect(left.get("ATV7")?.atMs).toBeNull();
  expect(stayed(left, present("ATV7"), NONE, 100 + KEPT_MS - 1).has("ATV5")).toBe(true);
  expect(stayed(left, present("ATV7"), NONE, 100 + KEPT_MS).has("ATV5")).toBe(false);
});

test("an open form keeps its card for as long as it is open", () => {
  const open = new Set(["ATV5"]);
  const left = stayed(stayed(new Map(), present("ATV5"), open, 0), present(), open, 100);
  expect(stayed(left, present(), open, 10 * KEPT_MS).has("ATV5")).toBe(true);
  expect(stayed(left, present(), NONE, 10 * KEPT_MS).has("ATV5")).toBe(false);
});

test("whoever comes back is here again", () => {
  const left = stayed(stayed(new Map(), present("ATV5"), NONE, 0), present(), NONE, 100);
  expect(stayed(left, present("ATV5"), NONE, 200).get("ATV5")?.atMs).toBeNull();
});
