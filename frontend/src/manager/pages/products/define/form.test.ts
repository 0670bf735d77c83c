import { expect, test, vi } from "vitest";
import { defineProduct } from "../../../../api/products";
import type { ProductAnswer } from "./draft";
import { begin, edit, send, written } from "./form";

vi.mock("../../../../api/products", () => ({ defineProduct: vi.fn() }));
vi.mock("../../../plant-asked", () => ({ plantAsked: { now: vi.fn() } }));

const defined = { id: "p9", name: "Pump", lot: 4, ability: "tote", bill: { shaft: 2 }, machines: { M1: 30 }, documents: [], revision: 1 } as unknown as ProductAnswer;

test("what is written while a product is sent stays, for the revision that was kept", async () => {
  begin(null);
  edit({ id: "p9", name: "Pump ", lot: "4" });
  vi.mocked(defineProduct).mockImplementation(async () => {
    edit({ lot: "5" });
    return await Promise.resolve(defined);
  });
  await send();
  expect(written.value).toMatchObject({ name: "Pump", lot: "5", bill: [{ what: "shaft", amount: "2" }], etag: '"1"' });
});

test("an answer about one product changes nothing of another one that was opened since", async () => {
  begin(null);
  edit({ id: "p9" });
  vi.mocked(defineProduct).mockImplementation(async () => {
    begin(null);
    edit({ id: "p10" });
    return await Promise.resolve(defined);
  });
  await send();
  expect([written.value.id, written.value.etag]).toEqual(["p10", ""]);
});
