/** Removing of products: several at once, and what became of each. */
import { signal } from "@preact/signals";
import { removeProducts } from "../../../../api/products";
import { fetchTransport } from "../../../../api/transports";
import type { components } from "../../../../api/types";
import type { Names } from "../../../../plant/names";
import { world } from "../../../../stream/stream";
import { format, t } from "../../../../text/views/products";
import { faultText } from "../../../../text/views/rows/fault-text";
import { plantAsked } from "../../../plant-asked";
import { problemText } from "../../../problem-text";
import { names as namesNow, placeOf } from "../../../state";

export type Definition = components["schemas"]["DefinitionAnswer"];
type Removed = components["schemas"]["RemovedProduct"];
type Reason = Removed["reasons"][number];

interface Stays {
  readonly name: string;
  readonly reason: string;
  /** Of those that need it and have not ended, the first ones. */
  readonly orders: readonly Called[];
  readonly transports: readonly Called[];
}

interface Called {
  readonly id: string;
  readonly text: string;
}

/** As many as one request takes. */
const AT_ONCE = 500;

/** Ids of those whose box is ticked. */
export const ticked = signal<ReadonlySet<string>>(new Set());
/** Those that stay, and why. */
export const kept = signal<readonly Stays[]>([]);
/** How many were removed last; null before, and where it was none. */
export const removed = signal<number | null>(null);
export const removing = signal(false);

/** When the view is left, or the answer was read. */
export function forget(): void {
  ticked.value = new Set();
  kept.value = [];
  removed.value = null;
}

export function tick(ids: readonly string[], on: boolean): void {
  const after = new Set(ticked.value);
  for (const id of ids) {
    if (on) after.add(id);
    else after.delete(id);
  }
  ticked.value = after;
}

/** Those that people have defined, by who did it last, most of them first. */
export function authorsOf(definitions: readonly Definition[]): readonly { readonly by: string; readonly count: number }[] {
  const counts = new Map<string, number>();
  for (const { by } of definitions) counts.set(by, (counts.get(by) ?? 0) + 1);
  return [...counts].map(([by, count]) => ({ by, count })).sort((one, other) => other.count - one.count || (one.by < other.by ? -1 : 1));
}

/**
 * In requests of as many as one takes. A part may stand in one before the product that needs it:
 * what was kept is tried again for as long as something goes.
 *
 * @returns the last answer about each
 */
export async function inTurns(ids: readonly string[], ask: typeof removeProducts): Promise<readonly Removed[]> {
  const told = new Map<string, Removed>();
  let left = [...ids];
  for (let gone = true; gone && left.length > 0; ) {
    gone = false;
    for (let from = 0; from < left.length; from += AT_ONCE) {
      for (const each of await ask(left.slice(from, from + AT_ONCE))) {
        told.set(each.id, each);
        gone ||= each.result === "removed";
      }
    }
    left = left.filter((id) => told.get(id)?.result === "needed");
    // All of them were in one request: it has looked at them together.
    if (ids.length <= AT_ONCE) break;
  }
  return [...told.values()];
}

export async function removeAll(chosen: readonly Definition[]): Promise<void> {
  const names = new Map(chosen.map(({ id, name }) => [id, name]));
  removing.value = true;
  kept.value = [];
  removed.value = null;
  try {
    const told = await inTurns([...names.keys()], removeProducts);
    const gone = told.filter(({ result }) => result === "removed" || result === "unknown").map(({ id }) => id);
    tick(gone, false);
    removed.value = gone.length === 0 ? null : gone.length;
    const stay = told.filter(({ id }) => !gone.includes(id));
    kept.value = await Promise.all(stay.map(async (each) => {
      const transports = await transportsOf(each);
      return { name: names.get(each.id) ?? each.id, reason: await reasonOf(each, transports), orders: ordersOf(each, orderText), transports };
    }));
  } catch (error) {
    kept.value = [{ name: t("products.removeAny"), reason: problemText(error), orders: [], transports: [] }];
  } finally {
    removing.value = false;
    // Whatever names products by the plant knows it at once.
    void plantAsked.now();
  }
}

async function reasonOf({ reasons, result }: Removed, transports: readonly Called[]): Promise<string> {
  if (result === "in_plant_file") return t("products.inPlantFile");
  const texts = new Map(transports.map(({ id, text }) => [id, text]));
  const called = { needed_by_order: orderText, needed_by_product: namesNow.value, needed_by_transport: (id: string) => texts.get(id) ?? id };
  return (await Promise.all(reasons.map(async (each) => await faultText(asCalled(each, called))))).join(" ");
}

/** What panels call an order: its reference, or else its id, and its customer. */
function orderText(id: string): string {
  const order = world.value?.orders.get(id);
  return [order?.reference ?? id, order?.customer].filter(Boolean).join(" · ");
}

/** What panels call a plain transport: what it brings, and where to; its id where that is not told. */
async function transportText(id: string): Promise<string> {
  try {
    const { item, quantity, thing, to } = await fetchTransport(id);
    return `${thing ?? `${format.count(quantity)} ${namesNow.value(item)}`} → ${placeOf(to)}`;
  } catch {
    return id;
  }
}

const BETWEEN = ", ";
/** Stands for those that are not named. */
const MORE = "…";

/** A reason that names what needs a product as people call it, where the gateway names it by id. */
export function asCalled(reason: Reason, called: Readonly<Record<string, Names>>): Reason {
  const name = called[reason.code ?? ""];
  if (name === undefined) return reason;
  const ids = (reason.values?.names ?? "").split(BETWEEN);
  return { ...reason, values: { ...reason.values, names: ids.map((id) => (id === MORE ? id : name(id))).join(BETWEEN) } };
}

/** The orders that keep a product, as far as they are named. */
export function ordersOf({ reasons }: Pick<Removed, "reasons">, called: Names): readonly Called[] {
  return named(reasons, "needed_by_order").map((id) => ({ id, text: called(id) }));
}

/** The plain transports that keep a product, as far as they are named. */
async function transportsOf({ reasons }: Pick<Removed, "reasons">): Promise<readonly Called[]> {
  return await Promise.all(named(reasons, "needed_by_transport").map(async (id) => ({ id, text: await transportText(id) })));
}

/** The ids that a kind of reason names. */
function named(reasons: readonly Reason[], kind: string): readonly string[] {
  const told = reasons.filter(({ code }) => code === kind).flatMap(({ values }) => (values?.names ?? "").split(BETWEEN));
  return told.filter((id) => id !== MORE && id !== "");
}
