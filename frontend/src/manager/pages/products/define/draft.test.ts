import { describe, expect, test } from "vitest";
import { draftOf, empty, partOf, twice, type Written, writtenOf } from "./draft";

const written: Written = {
  ...empty("tote"),
  id: "P9",
  name: " Bracket ",
  lot: "4",
  bill: [{ what: "", amount: "" }, { what: "steel", amount: "2" }, { what: "shaft", amount: "many" }],
  machines: [{ what: "M1", amount: "12,5" }],
  documents: [{ name: "CAD", address: " https://plm.example/x ", media_type: "text/plain", sha256: "AB" }],
};

test("a form becomes a definition, without its empty rows", () => {
  expect(draftOf(written)).toEqual({
    name: "Bracket",
    lot: 4,
    ability: "tote",
    bill: { steel: 2, shaft: "many" },
    machines: { M1: 12.5 },
    documents: [{ name: "CAD", address: "https://plm.example/x", media_type: "text/plain", sha256: "ab" }],
  });
});

test("a product that is changed is sent back as it was read", () => {
  const product = { id: "P1", name: "Gear unit", lot: 4, bill: { shaft: 2 }, ability: "tote", machines: { M1: 36 }, documents: [], revision: 3 };
  const read = writtenOf(product);
  expect(read.etag).toBe('"3"');
  expect(draftOf(read)).toEqual({ name: "Gear unit", lot: 4, bill: { shaft: 2 }, ability: "tote", machines: { M1: 36 }, documents: [] });
});

test("what stands twice is told before it replaces itself", () => {
  expect(twice(written.bill)).toBeNull();
  expect(twice([...written.bill, { what: "steel", amount: "1" }])).toBe("steel");
});

describe("a complaint is shown at its field", () => {
  test.each([
    ["lot", "lot"], ["bill.shaft", "bill.2"], ["bill[0].material", "bill.1"], ["bill.gold", "bill"], ["machines.M1", "machines.0"],
    ["machines", "machines"], ["documents[0].address", "documents.0"], ["documents", "documents"], ["product", "id"], ["colour", ""],
  ])("%s at %s", (field, part) => {
    expect(partOf(field, written)).toBe(part);
  });
});
