import { expect, test } from "vitest";
import type { OrderView } from "../../../api/types";
import { moved } from "./change-costs";

const order = (id: string, ...products: string[]): OrderView => ({ id, items: products.map((product) => ({ product })) }) as unknown as OrderView;

const QUEUE = [order("A", "pump"), order("B", "gear"), order("C", "pump", "gear"), order("D", "pump")];

test.each([
  ["D", "A", ["A", "C"], []],
  ["D", "B", ["C"], []],
  ["D", "C", ["C"], []],
  ["B", "A", [], []],
  ["A", "D", [], ["C"]],
  ["A", "B", [], []],
  ["B", "D", [], ["C"]],
])("%s before %s passes %j and lets %j pass", (which, before, passes, letsPass) => {
  const of = (id: string): OrderView => QUEUE.find((each) => each.id === id) ?? order(id);
  const move = moved(of(which), of(before), QUEUE);
  expect([move.passes, move.letsPass].map((orders) => orders.map(({ id }) => id))).toEqual([passes, letsPass]);
});
