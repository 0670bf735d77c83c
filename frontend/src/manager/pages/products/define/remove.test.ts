import { expect, test, vi } from "vitest";
import { removeProducts } from "../../../../api/products";
import { fetchTransport } from "../../../../api/transports";
import type { PlantFile } from "../../../../api/types";
import "../../../../text/in-english";
import { plant } from "../../../state";
import { addressOfTransport } from "../../../views";
import { linksTo } from "./NeedLinks";
import { asCalled, authorsOf, type Definition, inTurns, kept, ordersOf, removeAll, removed } from "./remove";

vi.mock("../../../../api/products", () => ({ removeProducts: vi.fn(), fetchDefinitions: vi.fn() }));
vi.mock("../../../../api/transports", () => ({ fetchTransport: vi.fn() }));
vi.mock("../../../plant-asked", () => ({ plantAsked: { now: async () => { await Promise.resolve(); } } }));

const of = (id: string, by: string): Definition => ({ id, by, name: id, revision: 1, at_s: 0, state: "made" });

test("who has defined most comes first", () => {
  const found = authorsOf([of("a", "maria"), of("b", "ERP"), of("c", "ERP"), of("d", "anna")]);
  expect(found).toEqual([{ by: "ERP", count: 2 }, { by: "anna", count: 1 }, { by: "maria", count: 1 }]);
});

test("a part that stands in a request before the product that needs it goes in the next turn", async () => {
  const ids = ["part", ...Array.from({ length: 499 }, (_, i) => `p${i}`), "whole"];
  const gone = new Set<string>();
  const sizes: number[] = [];
  const told = await inTurns(ids, async (asked) => {
    sizes.push(asked.length);
    return await Promise.resolve(asked.map((id) => {
      const needed = id === "p7" || (id === "part" && !gone.has("whole"));
      if (!needed) gone.add(id);
      return { id, result: needed ? ("needed" as const) : ("removed" as const), reasons: [] };
    }));
  });
  expect(sizes).toEqual([500, 1, 2, 1]);
  expect(told.filter(({ result }) => result === "needed").map(({ id }) => id)).toEqual(["p7"]);
});

test("what was looked at together is not asked again", async () => {
  let asked = 0;
  await inTurns(["a", "b"], async (ids) => {
    asked += 1;
    return await Promise.resolve(ids.map((id) => ({ id, result: id === "a" ? ("removed" as const) : ("needed" as const), reasons: [] })));
  });
  expect(asked).toBe(1);
});

const needed = (code: string, names: string) => ({ field: "product", reason: "", code, values: { count: "7", names } });
const called = (id: string): string => (id === "O-1" ? "PO 17 · Acme" : id);

test("what keeps a product is named as people call it, where the gateway names it by id", () => {
  const found = ["needed_by_order", "needed_by_machine"].map((code) => asCalled(needed(code, "O-1, O-2, …"), { needed_by_order: called }));
  expect(found.map(({ values }) => values)).toEqual([{ count: "7", names: "PO 17 · Acme, O-2, …" }, { count: "7", names: "O-1, O-2, …" }]);
});

test("there are ways to the orders that are named, and to nothing else", () => {
  const reasons = [needed("needed_by_order", "O-1, O-2, …"), needed("needed_by_machine", "M1")];
  expect(ordersOf({ reasons }, called)).toEqual([{ id: "O-1", text: "PO 17 · Acme" }, { id: "O-2", text: "O-2" }]);
  expect(ordersOf({ reasons: [needed("needed_by_order", "…")] }, called)).toEqual([]);
});

test("transports that keep a product are named by what they bring and where to, and none is not said to be removed", async () => {
  plant.value = { materials: [], products: [{ id: "g1", name: "Gear unit G1" }] } as unknown as PlantFile;
  const reasons = [needed("needed_by_transport", "T-1, T-2, T-3")];
  vi.mocked(removeProducts).mockResolvedValue([{ id: "g1", result: "needed", reasons }]);
  vi.mocked(fetchTransport).mockImplementation(async (id) => {
    if (id === "T-3") throw new Error("forgotten");
    return await Promise.resolve({ item: id === "T-1" ? "g1" : ".thing", quantity: 4, thing: id === "T-1" ? null : "a pallet", to: "M8" } as Awaited<ReturnType<typeof fetchTransport>>);
  });
  await removeAll([{ ...of("g1", "maria"), name: "Gear unit G1" }]);
  expect(kept.value[0]?.reason).toContain("(4 Gear unit G1 → M8, a pallet → M8, T-3)");
  expect(kept.value[0]?.transports).toEqual([{ id: "T-1", text: "4 Gear unit G1 → M8" }, { id: "T-2", text: "a pallet → M8" }, { id: "T-3", text: "T-3" }]);
  expect(linksTo(kept.value[0]?.transports ?? [], addressOfTransport).map(({ href, text }) => [href, text])).toEqual([
    ["#transports/T-1", "4 Gear unit G1 → M8"], ["#transports/T-2", "a pallet → M8"], ["#transports/T-3", "T-3"],
  ]);
  expect(removed.value).toBe(null);
});
