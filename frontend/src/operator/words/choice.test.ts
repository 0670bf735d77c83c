import { describe, expect, test } from "vitest";
import { type Choice, isWhole, kindsAt, ofKind, ofLoad, type Place, scanned, withItem, withQuantity } from "./choice";

const level = (item: string, pieces: number) => ({ item, level: pieces, capacity: 99, reorder_point: 0, on_order: 0, spare: 0 });
const place: Place = {
  buffers: [level("housing", 11), level("shaft", 38)],
  goods: [level("pump-p3", 2), level("gear-unit-g2", 0)],
  product: "pump-p3",
  unconfirmed: [{ vehicle: "ATV3", item: "shaft", quantity: 12, goes: false }],
  toCome: null,
};
const load: Choice = { kind: "arrived", item: "shaft", vehicle: "ATV3", quantity: 12 };

describe("what is chosen", () => {
  test("a finished piece is one of what is being made", () => {
    expect(ofKind("made", place)).toEqual({ kind: "made", item: "pump-p3", vehicle: "", quantity: 1 });
    expect(ofKind("made", { ...place, product: "" }).item).toBe("");
  });

  test("a count begins with what is believed", () => {
    expect(withItem(ofKind("stock_is", place), "shaft", place)).toEqual({ kind: "stock_is", item: "shaft", vehicle: "", quantity: 38 });
  });

  test("a load that was taken is taken", () => {
    expect(ofLoad({ vehicle: "ATV3", item: "pump-p3", quantity: 4, goes: true }).kind).toBe("taken");
  });

  test.each([[-1, 0], [1e9, 100], [2.7, 2], [Number.NaN, 1]])("a number of finished pieces %d is %d", (said, quantity) => {
    expect(withQuantity(ofKind("made", place), said).quantity).toBe(quantity);
  });

  test("no pieces can be said of a load and of a count only", () => {
    const none = (choice: Choice) => isWhole(withQuantity(choice, 0));
    expect(none(load)).toBe(true);
    expect(none(withItem(ofKind("stock_is", place), "shaft", place))).toBe(true);
    expect(none(ofKind("made", place))).toBe(false);
    expect(none({ ...load, vehicle: "" })).toBe(false);
    expect(isWhole(ofKind("arrived", place))).toBe(false);
  });
});

describe("a code", () => {
  test("of an item chooses its load that waits, and the same code once more says it", () => {
    const first = scanned("SHAFT", null, place);
    expect(first).toEqual({ does: "choose", choice: load });
    expect(scanned("shaft", load, place)).toEqual({ does: "say", choice: load });
  });

  test("with a number corrects it, and says it when it comes again", () => {
    const ten = { ...load, quantity: 10 };
    expect(scanned("shaft*10", load, place)).toEqual({ does: "choose", choice: ten });
    expect(scanned("shaft*10", ten, place)).toEqual({ does: "say", choice: ten });
  });

  test("of a product is a finished piece, of another material an arrival by hand", () => {
    expect(scanned("gear-unit-g2*3", null, place)).toMatchObject({ choice: { kind: "made", item: "gear-unit-g2", quantity: 3 } });
    expect(scanned("housing", null, place)).toMatchObject({ choice: { kind: "arrived", item: "housing", vehicle: "" } });
  });

  test("of what has happened waits for an item, which the next code tells", () => {
    const step = scanned("stock_is", null, place);
    expect(step).toMatchObject({ does: "choose", choice: { kind: "stock_is", item: "" } });
    const before = { kind: "stock_is", item: "", vehicle: "", quantity: 1 } as const;
    expect(scanned("housing*9", before, place)).toMatchObject({ choice: { kind: "stock_is", item: "housing", quantity: 9 } });
  });

  test("ok says what is chosen, and nothing else", () => {
    expect(scanned("ok", load, place)).toEqual({ does: "say", choice: load });
    expect(scanned("ok", null, place)).toEqual({ does: "unknown" });
    expect(scanned("ok", ofKind("arrived", place), place)).toEqual({ does: "unknown" });
  });

  test("that nobody knows changes nothing", () => {
    expect(scanned("4006381333931", load, place)).toEqual({ does: "unknown" });
  });
});

describe("at a storage", () => {
  const storage: Place = { buffers: [level("shaft", 38)], goods: [], product: "", unconfirmed: [], toCome: null };

  test("nothing is made, and a code of a material is an arrival by hand", () => {
    expect(kindsAt(storage)).toEqual(["arrived", "taken", "stock_is"]);
    expect(scanned("made", null, storage)).toEqual({ does: "unknown" });
    expect(scanned("shaft*5", null, storage)).toMatchObject({ choice: { kind: "arrived", item: "shaft", vehicle: "", quantity: 5 } });
  });
});

describe("at the gate", () => {
  const gate: Place = { buffers: [], goods: [], product: "", unconfirmed: [], toCome: [{ goal: "O-7-1.1", product: "pump-p3", quantity: 6 }] };
  const all: Choice = { kind: "arrived", item: "O-7-1.1", vehicle: "", quantity: 6 };

  test("the code of a label chooses all that is to come of its goal, and the same code once more says it", () => {
    expect(scanned("O-7-1.1", null, gate)).toEqual({ does: "choose", choice: all });
    expect(scanned("o-7-1.1", all, gate)).toEqual({ does: "say", choice: all });
    expect(scanned("o-7-1.1*4", all, gate)).toEqual({ does: "choose", choice: { ...all, quantity: 4 } });
  });

  test("things only arrive", () => {
    expect(kindsAt(gate)).toEqual(["arrived"]);
    for (const word of ["stock_is", "Made", "ok"]) expect(scanned(word, null, gate)).toEqual({ does: "unknown" });
  });

  test("the code of a goal that is not listed is chosen as it is spelt, with the number that it tells", () => {
    const unlisted: Choice = { kind: "arrived", item: "O-9-3.1", vehicle: "", quantity: 0 };
    expect(scanned(" O-9-3.1 ", null, gate)).toEqual({ does: "choose", choice: unlisted });
    expect(scanned("O-9-3.1", all, gate)).toEqual({ does: "choose", choice: unlisted });
    expect(scanned("O-9-3.1", unlisted, gate)).toEqual({ does: "choose", choice: unlisted });
    expect(scanned("ok", unlisted, gate)).toEqual({ does: "unknown" });
    const four = { ...unlisted, quantity: 4 };
    expect(scanned("O-9-3.1*4", unlisted, gate)).toEqual({ does: "choose", choice: four });
    expect(scanned("o-9-3.1*4", four, gate)).toEqual({ does: "say", choice: four });
    expect(scanned("O-9-3.1", four, gate)).toEqual({ does: "say", choice: four });
  });
});
