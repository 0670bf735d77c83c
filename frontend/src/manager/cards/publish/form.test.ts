import { expect, test } from "vitest";
import type { PlantFile } from "../../../api/types";
import { plant } from "../../state";
import { needsOf, quantityOf } from "./draft";
import { complaints, draft, edit } from "./form";

const made = (...ids: string[]): PlantFile => ({ products: ids.map((id) => ({ id })) }) as unknown as PlantFile;

test("the product in the form stays when others are defined, and leaves it empty when it is removed", () => {
  expect(draft.value.product).toBe("");
  plant.value = made("g1", "g2");
  expect(draft.value.product).toBe("g1");
  plant.value = made("new", "g1", "g2");
  expect(draft.value.product).toBe("g1");
  plant.value = made("new", "g2");
  expect(draft.value.product).toBe("");
  edit("product", "g2");
  plant.value = made("newer", "new", "g2");
  expect(draft.value.product).toBe("g2");
});

test("an impossible quantity is told at once, and nothing is foreseen for it", () => {
  const plant = { products: [{ id: "g", bill: [{ material: "m", quantity: 2 }] }], materials: [{ id: "m", name: "Rotor", lot: 40 }] } as unknown as PlantFile;
  for (const impossible of ["0", "-3", "1.5", "100001", "many"]) {
    edit("quantity", impossible);
    expect(complaints.value.quantity).toContain("A whole number from 1 to");
    expect(needsOf(plant, "g", quantityOf(draft.value))).toEqual([]);
  }
  edit("quantity", "");
  expect(complaints.value.quantity).toBeUndefined();
  edit("quantity", "40");
  expect(complaints.value.quantity).toBeUndefined();
  expect(needsOf(plant, "g", quantityOf(draft.value))).toEqual([{ name: "Rotor", pieces: 80, lots: 2 }]);
});
