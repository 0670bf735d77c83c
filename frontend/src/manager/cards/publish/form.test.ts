import { expect, test } from "vitest";
import type { PlantFile } from "../../../api/types";
import { plant } from "../../state";
import { draft, edit } from "./form";

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
