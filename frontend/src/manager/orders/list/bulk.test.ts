import { beforeEach, expect, test, vi } from "vitest";
import type { OrderView } from "../../../api/types";
import { doAll, forget, refused, running, tick, ticked } from "./bulk";

const cancelOrder = vi.hoisted(() => vi.fn<(order: string) => Promise<void>>());
vi.mock("../../../api/client", () => ({ cancelOrder, releaseOrder: vi.fn(), revokeOrder: vi.fn() }));
vi.mock("../../problem-text", () => ({ problemText: (error: Error) => error.message }));

const orders = ["O-1", "O-2"].map((id) => ({ id }) as OrderView);
const told = () => refused.value.map(({ order, reason }) => [order.id, reason]);

beforeEach(() => {
  forget();
  cancelOrder.mockReset();
});

test("what was done is ticked no more, and what was refused says why", async () => {
  for (const { id } of orders) tick(id, true);
  cancelOrder.mockResolvedValueOnce().mockRejectedValueOnce(new Error("it is over"));
  await doAll("cancel", orders);
  expect([...ticked.value]).toEqual(["O-2"]);
  expect(told()).toEqual([["O-2", "it is over"]]);
  expect(running.value).toBeNull();
});

test("a new deed has only its own refusals", async () => {
  cancelOrder.mockRejectedValue(new Error("it is over"));
  await doAll("cancel", orders);
  expect(told()).toHaveLength(2);
  let go = (): void => undefined;
  cancelOrder.mockReturnValue(new Promise((done) => { go = done; }));
  const second = doAll("cancel", orders.slice(0, 1));
  expect(told()).toEqual([]);
  go();
  await second;
  expect(told()).toEqual([]);
});

test("whoever has left the list is told of no refusal when they are back", async () => {
  let refuse: (reason: Error) => void = () => undefined;
  cancelOrder.mockReturnValue(new Promise((_done, fail) => { refuse = fail; }));
  const deed = doAll("cancel", orders.slice(0, 1));
  forget();
  refuse(new Error("it is over"));
  await deed;
  expect(told()).toEqual([]);
});
