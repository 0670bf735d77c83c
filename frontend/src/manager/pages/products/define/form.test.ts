import { expect, test, vi } from "vitest";
import { defineProduct } from "../../../../api/products";
import { Problem } from "../../../../api/problem";
import type { ProductAnswer } from "./draft";
import { begin, complaints, edit, openings, outcome, send, written } from "./form";

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

test("what is refused after another product was opened is told by its name, and restored as it was typed", async () => {
  begin(null);
  edit({ id: "p9", name: "Pump", lot: "0" });
  vi.mocked(defineProduct).mockImplementation(async () => {
    begin(null);
    edit({ id: "p10" });
    return await Promise.reject(new Problem(422, "too few", [{ field: "lot", reason: "too few" }]));
  });
  await send();
  expect([written.value.id, complaints.value, outcome.value]).toEqual(["p10", {}, null]);
  expect(openings.refused.value.map(({ text }) => text)).toEqual(["Not done for Pump: too few"]);
  openings.refused.value[0]?.restore();
  expect([written.value.id, written.value.lot, complaints.value]).toEqual(["p9", "0", { lot: "too few" }]);
});
