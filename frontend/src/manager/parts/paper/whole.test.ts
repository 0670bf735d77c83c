import { expect, test } from "vitest";
import { readWhole } from "./whole";

const pagesOf = (all: readonly number[], size: number) => (after: string) => {
  const from = Number(after);
  const next = from + size < all.length ? String(from + size) : null;
  return Promise.resolve({ items: all.slice(from, from + size), next_cursor: next });
};
const numbers = Array.from({ length: 23 }, (_, i) => i);

test("all pages of a list are read, in their order, and how far it is, is told", async () => {
  const told: number[] = [];
  expect(await readWhole(pagesOf(numbers, 10), (rows) => told.push(rows))).toEqual({ items: numbers, next_cursor: null });
  expect(told).toEqual([10, 20, 23]);
});

test("no more than the bound, and then it is known that there are more", async () => {
  const found = await readWhole(pagesOf(numbers, 10), () => undefined, 15);
  expect(found.items).toEqual(numbers.slice(0, 15));
  expect(found.next_cursor).not.toBeNull();
  expect((await readWhole(pagesOf(numbers, 10), () => undefined, 20)).next_cursor).toBe("20");
  expect((await readWhole(pagesOf(numbers, 10), () => undefined, 22)).next_cursor).not.toBeNull();
  expect((await readWhole(pagesOf(numbers, 10), () => undefined, 23)).next_cursor).toBeNull();
});
