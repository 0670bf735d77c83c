import { expect, test } from "vitest";
import { en } from "../text/editor/en";
import { fieldText, whereOf, whereText } from "./where";

const data = {
  nodes: [{ id: "n1" }, { id: "n2" }],
  lanes: [{ start: "n1", end: "n2" }],
  machines: [{ id: "M1" }, { id: "M3", box: {} }],
  products: [{ id: "g1" }],
};
const known: Readonly<Record<string, unknown>> = en;
const word = (group: string, name: string): string => {
  const said = known[`${group}.${name}`];
  return typeof said === "string" ? said : name.replaceAll("_", " ");
};

test.each([
  ["nodes[1].x_m", "Node n2 · x, m"],
  ["lanes[0].speed_limit_mps", "Lane n1 – n2 · Speed limit, m/s"],
  ["machines[1].box.width_m", "Machine M3 · Box · Width, m"],
  ["machines[1].makes[0].product", "Machine M3 · Makes 1 · Product"],
  ["machines[1]", "Machine M3"],
  ["machines[7].node", "Machine ? · Dock node"],
  ["products[0].lot", "Products · g1 · Pieces in a container"],
  ["products[0].bill[1].material", "Products · g1 · Made of 2 · Material"],
  ["machines", "Machine"],
  ["something_new[0].else", "something new 1 · else"],
])("the checks' %s is called %s", (field, said) => {
  expect(whereText(field, data, word)).toBe(said);
});

test("in the form of a thing a finding is called by its field alone", () => {
  expect(fieldText("machines[1].makes[0].product", word)).toBe("Makes 1 · Product");
  expect(fieldText("machines[1].station", word)).toBe(word("field", "station"));
  expect(fieldText("machines[1]", word)).toBe("");
});

test("a way leads to what is drawn, to an entry of a list, or nowhere", () => {
  expect(whereOf("machines[1].makes[0].product")).toEqual({ chosen: { section: "machines", index: 1 }, listed: null, whole: null, steps: ["makes", "0", "product"] });
  expect(whereOf("products[0].lot")).toEqual({ chosen: null, listed: { section: "products", index: 0 }, whole: null, steps: ["lot"] });
  expect(whereOf("width_m")).toEqual({ chosen: null, listed: null, whole: null, steps: ["width_m"] });
});

test("a way leads to a list that a finding is about as a whole, drawn or not", () => {
  expect(whereOf("warehouses").whole).toBe("warehouses");
  expect(whereOf("products").whole).toBe("products");
  expect(whereOf("warehouses[0]").whole).toBe(null);
  expect(whereOf("warehouses[0].stocks").whole).toBe(null);
  expect(whereOf("width_m").whole).toBe(null);
});
