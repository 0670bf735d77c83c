/** What a storage or a warehouse of a draft keeps, and from where it comes: pure. */
import { type Data, entries, type Place } from "./model";

export interface Stock {
  readonly material?: string | null;
  readonly capacity?: number | null;
  readonly reorder_point?: number | null;
  readonly lot?: number | null;
}

/** The stocks of a place; none where nobody has said any, null for what is no list of them. */
export function stocksOf(value: unknown): readonly Stock[] | null {
  if (value === undefined || value === null) return [];
  const isList = Array.isArray(value) && value.every((each) => typeof each === "object" && each !== null && !Array.isArray(each));
  return isList ? (value as Stock[]) : null;
}

interface Item {
  readonly id: string;
  readonly lot?: number;
  readonly buffer?: number;
}

const itemsOf = (data: Data, section: string): readonly Item[] => entries<Item | null>(data, section).filter((each) => typeof each?.id === "string") as Item[];

/** What can be kept: materials, and products that other machines use. */
export const keepable = (data: Data): readonly Item[] => [...itemsOf(data, "materials"), ...itemsOf(data, "products").filter(({ buffer }) => (buffer ?? 0) > 0)];

/** One stock more: of the first thing that is not kept yet, with room for some containers. */
export function withStock(data: Data, stocks: readonly Stock[]): readonly Stock[] {
  const kept = new Set(stocks.map(({ material }) => material));
  const item = keepable(data).find(({ id }) => !kept.has(id));
  return item === undefined ? stocks : [...stocks, { material: item.id, capacity: CONTAINERS * (item.lot ?? 1) }];
}

const CONTAINERS = 10;

/** The same with one of them otherwise; what is null of it is left out, as the file has it. */
export function withChanged(stocks: readonly Stock[], index: number, fields: Stock): readonly Stock[] {
  return stocks.map((stock, at) => {
    if (at !== index) return stock;
    const { reorder_point: point, lot, ...rest } = { ...stock, ...fields };
    return { ...rest, ...(point == null ? {} : { reorder_point: point }), ...(lot == null ? {} : { lot }) };
  });
}

type Keeper = Place & { readonly stocks?: unknown };

/** The source warehouses from which vehicles can bring something. */
export function warehousesOf(data: Data, material: string | null | undefined): readonly string[] {
  return entries<Keeper | null>(data, "warehouses").flatMap((each) => {
    const keeps = each?.kind === "source" && stocksOf(each.stocks)?.some((stock) => stock.material === material);
    return each && keeps ? [each.id] : [];
  });
}
