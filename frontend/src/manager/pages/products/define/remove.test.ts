import { expect, test } from "vitest";
import { authorsOf, type Definition, inTurns } from "./remove";

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
