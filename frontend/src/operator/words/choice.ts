/**
 * What somebody is about to say: chosen by a first touch, or a first code, and said by a second one. Pure.
 *
 *     code            chooses
 *     ITEM            the load of this item that waits for a word; else a finished piece of a product; else one that has arrived
 *     ITEM*12         the same, 12 of it
 *     made, arrived…  what has happened
 *     ok              says it; so does the same code once more
 *
 * At the gate a code is a goal, also one that is not listed: the gate refuses what it has not admitted.
 */
import type { LoadView, ToComeView } from "../../api/types";
import type { WordKind } from "../commands/life";

const KINDS: readonly WordKind[] = ["made", "scrapped", "arrived", "taken", "stock_is"];

const AT_GATE: readonly WordKind[] = ["arrived"];

const OF_LOADS: readonly WordKind[] = ["arrived", "taken", "stock_is"];

export interface Choice {
  readonly kind: WordKind;
  /** Empty while it is not chosen. */
  readonly item: string;
  readonly vehicle: string;
  readonly quantity: number;
}

interface Level {
  readonly item: string;
  readonly level: number;
}

/** A place that people work. */
export interface Place {
  /** Material. */
  readonly buffers: readonly Level[];
  /** What is made there; none at a storage. */
  readonly goods: readonly Level[];
  /** What is being made. */
  readonly product: string;
  /** Null where its body is not people. */
  readonly unconfirmed: readonly LoadView[] | null;
  /** Of the delivery gate: pieces that are to come, by goal; null elsewhere. */
  readonly toCome: readonly ToComeView[] | null;
}

export type Step =
  | { readonly does: "choose"; readonly choice: Choice }
  | { readonly does: "say"; readonly choice: Choice }
  | { readonly does: "unknown" };

/** The most that can be said at once. */
const MOST: Readonly<Record<WordKind, number>> = { made: 100, scrapped: 100, arrived: 1e6, taken: 1e6, stock_is: 1e6 };

/** What can be said there: where nothing is made, nothing is finished. */
export function kindsAt({ goods, toCome }: Pick<Place, "goods" | "toCome">): readonly WordKind[] {
  if (toCome) return AT_GATE;
  return goods.length === 0 ? OF_LOADS : KINDS;
}

export function itemsFor(kind: WordKind, { buffers, goods, toCome }: Place): readonly string[] {
  if (toCome) return toCome.map(({ goal }) => goal);
  const products = goods.map(({ item }) => item);
  return kind === "made" || kind === "scrapped" ? products : [...buffers.map(({ item }) => item), ...products];
}

export function ofKind(kind: WordKind, place: Place): Choice {
  const items = itemsFor(kind, place);
  const made = kind === "made" || kind === "scrapped";
  const item = made && items.includes(place.product) ? place.product : items.length === 1 ? (items[0] ?? "") : "";
  return withItem({ kind, item: "", vehicle: "", quantity: 1 }, item, place);
}

/** The same of an item: what lies there is what somebody expects to count. */
export function withItem(choice: Choice, item: string, { buffers, goods, toCome }: Place): Choice {
  const goal = toCome?.find((each) => each.goal === item);
  if (goal) return ofGoal(goal);
  const level = [...buffers, ...goods].find((each) => each.item === item)?.level ?? 0;
  return { ...choice, item, quantity: choice.kind === "stock_is" ? level : choice.quantity };
}

export function ofLoad({ goes, item, quantity, vehicle }: LoadView): Choice {
  return { kind: goes ? "taken" : "arrived", item, vehicle, quantity };
}

/** All that is to come of a goal. */
export function ofGoal({ goal, quantity }: ToComeView): Choice {
  return { kind: "arrived", item: goal, vehicle: "", quantity };
}

/** Another number; whatever is none leaves the one that was. */
export function withQuantity(choice: Choice, quantity: number): Choice {
  if (!Number.isFinite(quantity)) return choice;
  return { ...choice, quantity: Math.min(Math.max(Math.trunc(quantity), 0), MOST[choice.kind]) };
}

/** Whether it can be said: nobody finishes no piece, and nothing arrives by hand. */
export function isWhole({ item, kind, quantity, vehicle }: Choice): boolean {
  return item !== "" && (quantity > 0 || kind === "stock_is" || vehicle !== "");
}

/** What a code means after what was chosen before. */
export function scanned(code: string, before: Choice | null, place: Place): Step {
  const read = code.trim();
  const word = read.toLowerCase();
  if (word === "ok") return before && isWhole(before) ? { does: "say", choice: before } : { does: "unknown" };
  const kind = kindsAt(place).find((each) => each === word);
  if (kind !== undefined) return { does: "choose", choice: ofKind(kind, place) };
  const [, name = read, many] = /^(.+)\*(\d{1,7})$/.exec(read) ?? [];
  const item = itemOf(name, before, place);
  if (item === undefined) return { does: "unknown" };
  const counted = (choice: Choice): Choice => (many === undefined ? choice : withQuantity(choice, Number(many)));
  if (before?.item === item) {
    const again = counted(before);
    return again.quantity === before.quantity && isWhole(before) ? { does: "say", choice: before } : { does: "choose", choice: again };
  }
  if (before?.item === "" && itemsFor(before.kind, place).includes(item)) {
    return { does: "choose", choice: counted(withItem(before, item, place)) };
  }
  if (place.toCome) {
    const goal = place.toCome.find((each) => each.goal === item) ?? { goal: item, product: "", quantity: 0 };
    return { does: "choose", choice: counted(ofGoal(goal)) };
  }
  const load = place.unconfirmed?.find((each) => each.item === item);
  if (load) return { does: "choose", choice: counted(ofLoad(load)) };
  const isMade = itemsFor("made", place).includes(item);
  return { does: "choose", choice: counted({ kind: isMade ? "made" : "arrived", item, vehicle: "", quantity: 1 }) };
}

/** The item that a code names, spelt as it is known there; at the gate a code that nobody knows is a goal as it is spelt. */
function itemOf(code: string, before: Choice | null, place: Place): string | undefined {
  const isIt = (item: string): boolean => item.toLowerCase() === code.toLowerCase();
  const known = itemsFor("stock_is", place).find(isIt);
  if (known !== undefined || !place.toCome) return known;
  if (before && isIt(before.item)) return before.item;
  return KINDS.some(isIt) ? undefined : code;
}
