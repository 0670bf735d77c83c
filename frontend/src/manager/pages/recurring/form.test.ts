import { beforeEach, expect, test, vi } from "vitest";
import { addSchedule, previewRuns, type Schedule } from "../../../api/schedules";
import { Problem } from "../../../api/problem";
import type { PlantFile } from "../../../api/types";
import { plant } from "../../state";
import { before, begin, complaints, edit, lines, openings, outcome, preview, send, written } from "./form";

vi.mock("../../../api/schedules", () => ({ addSchedule: vi.fn(), changeSchedule: vi.fn(), previewRuns: vi.fn() }));

const made = (...ids: string[]): PlantFile => ({ products: ids.map((id) => ({ id, name: id })), materials: [] }) as unknown as PlantFile;

beforeEach(() => {
  vi.mocked(addSchedule).mockReset();
  plant.value = made("g1", "g2");
  begin(null);
  edit({ kind: "order", customer: "Acme", lines: [{ product: "g1", quantity: "4" }, { product: "g2", quantity: "5" }] });
});

test("a product that is gone is shown as none, and not sent", async () => {
  plant.value = made("g1");
  expect(lines.value.map(({ product }) => product)).toEqual(["g1", ""]);
  await send();
  expect(vi.mocked(addSchedule).mock.calls[0]?.[0].order?.items).toEqual([{ product: "g1", quantity: 4 }, { product: "", quantity: 5 }]);
});

test("as long as nobody knows the products, those that are written stay", async () => {
  plant.value = null;
  await send();
  expect(vi.mocked(addSchedule).mock.calls[0]?.[0].order?.items.map(({ product }) => product)).toEqual(["g1", "g2"]);
});

test("the next moments are those without the days and public holidays that are written", async () => {
  edit({ holidays: "2030-12-24", holidaysOf: " DE-BW " });
  await preview();
  expect(vi.mocked(previewRuns).mock.calls[0]?.[0]).toMatchObject({ holidays: ["2030-12-24"], holidays_of: "DE-BW" });
});

const kept = { id: "S-1", name: "Weekly", calendar: "0 6 * * 1,2,3,4,5", time_zone: "UTC", holidays: [], holidays_of: "", missed: "skip", transport: null, order: { customer: "Acme", reference: null, items: [{ product: "g1", quantity: 4 }], priority: "normal", due_after_s: null } } as unknown as Schedule;

test("what is written while it is sent stays, and is a change of what was kept", async () => {
  edit({ name: " Weekly " });
  vi.mocked(addSchedule).mockImplementation(async () => {
    edit({ customer: "Hall 3" });
    return await Promise.resolve(kept);
  });
  await send();
  expect([written.value.customer, written.value.name, before.value]).toEqual(["Hall 3", "Weekly", kept]);
});

test("an answer about what the form was closed with changes nothing in what was opened since", async () => {
  vi.mocked(addSchedule).mockImplementation(async () => {
    begin(null);
    edit({ name: "Other" });
    return await Promise.resolve(kept);
  });
  await send();
  expect([written.value.name, written.value.kind, before.value]).toEqual(["Other", "transport", null]);
});

test("what is refused after another one was opened is told by its name, and restored as it was typed", async () => {
  edit({ name: "Weekly", customer: "" });
  vi.mocked(addSchedule).mockImplementation(async () => {
    edit({ customer: "Hall 3" });
    begin(null);
    edit({ name: "Other" });
    return await Promise.reject(new Problem(422, "too short", [{ field: "order.customer", reason: "too short" }]));
  });
  await send();
  expect([written.value.name, complaints.value, outcome.value]).toEqual(["Other", {}, null]);
  expect(openings.refused.value.map(({ text }) => text)).toEqual(["Not done for Weekly: too short"]);
  openings.refused.value[0]?.restore();
  expect(written.value).toMatchObject({ name: "Weekly", kind: "order", customer: "Hall 3" });
  expect([complaints.value, openings.refused.value]).toEqual([{ customer: "too short" }, []]);
});
