import { expect, test } from "vitest";
import { Problem } from "./problem";
import { nameItemsBy, worded } from "./problem-words";

const FAULT = { field: "quantity", reason: "too large, says the gateway", code: "at_most", values: { most: "5" } };

test.each([
  ["its faults", new Problem(422, "quantity: too large", [FAULT], "unusable-fields"), "This is too large. 5 at most."],
  ["its kind", new Problem(409, "order O-1 is delivered; place another one", [], "order-ended"), "This order has ended. Place another one."],
  ["what is not there", new Problem(404, "no order has the id 'O-1'; GET /api/orders lists them", [], "unknown-order"), "There is no such thing, or no more."],
  ["a kind without words", new Problem(409, "as the gateway says it", [], "of-tomorrow"), "as the gateway says it"],
  ["no kind", new Problem(502, "HTTP 502"), "HTTP 502"],
])("a problem is told by %s", async (_by, problem, text) => {
  const after = await worded(problem);
  expect(after).toMatchObject({ status: problem.status, kind: problem.kind, message: text });
});

test("a material has its name in what people read, and its id in what programs do", async () => {
  nameItemsBy((id) => (id === "shaft" ? "Shaft" : id));
  const tooLarge = { field: "quantity", reason: "as the gateway says it", code: "load_too_large", values: { item: "shaft", most: "40", loads: "12 x 40 + 20" } };
  const only = { field: "item", reason: "as the gateway says it", code: "only_items", values: { items: "shaft, bolt" } };
  const after = await worded(new Problem(422, "quantity: too large", [tooLarge, only], "unusable-fields"));
  expect(after.errors.map(({ reason }) => reason)).toEqual(["One load of Shaft is 40 at most. Ask for several transports: 12 x 40 + 20.", "This key calls for Shaft, bolt only."]);
  expect(after.errors[0]?.values?.item).toBe("shaft");
});
