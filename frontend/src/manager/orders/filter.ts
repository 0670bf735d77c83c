/** Which orders are wanted. Pure. */
import type { OrderView } from "../../api/types";
import { holds } from "../parts/filters/match";
import type { Names } from "../../plant/names";
import { isClosed, isLate } from "./progress";

export const STATUSES = ["stored", "released", "in_production", "in_delivery", "delivered", "cancelled"] as const;

export interface Wanted {
  readonly words: string;
  /** Empty for any; "open" for those that have not ended. */
  readonly status: string;
  readonly product: string;
  readonly late: boolean;
}

export function isWanted(order: OrderView, wanted: Wanted, nowS: number, names: Names): boolean {
  const { late, product, status, words } = wanted;
  if (status === "open" ? isClosed(order) : status !== "" && order.status !== status) return false;
  if (product !== "" && !order.items.some((item) => item.product === product)) return false;
  if (late && !isLate(order, nowS)) return false;
  return holds(words, order.id, order.reference, order.customer, ...order.items.map((item) => names(item.product)));
}

/** The same orders as a table for a spreadsheet, as far as the gateway can tell them apart. */
export function tableOf({ status }: Wanted): string {
  const open = STATUSES.slice(0, 4);
  const asked = status === "open" ? open : status === "" ? [] : [status];
  return `/api/orders?${new URLSearchParams([...asked.map((each) => ["status", each]), ["format", "csv"]]).toString()}`;
}
