/** Which orders the address asks for, and as the gateway is asked for them. Pure. */
import type { OrdersQuery } from "../../api/client";
import type { Asked } from "../views";

export const STATUSES = ["stored", "released", "in_production", "in_delivery", "delivered", "cancelled"] as const;
type Status = (typeof STATUSES)[number];

const SORTED = ["work", "reference", "customer", "due", "created"] as const;

/** What the gateway is asked for: only what was filled in. Without an order of their own they come as people work at them. */
export function queryOf(said: Asked): OrdersQuery {
  const sort = SORTED.find((each) => each === said.sort) ?? "work";
  const since = momentOf(said.since);
  const until = momentOf(said.until);
  const status = statusesOf(said.status ?? "");
  return {
    ...(said.q ? { q: said.q } : {}),
    ...(status.length > 0 ? { status } : {}),
    ...(said.product ? { product: said.product } : {}),
    ...(said.late === "yes" ? { late: true } : {}),
    ...(since === null ? {} : { created_since: since }),
    ...(until === null ? {} : { created_before: until }),
    sort,
    descending: said.down === "yes",
  };
}

/** The same orders as a table for a spreadsheet, all of them. */
export function tableOf(said: Asked): string {
  return `/api/orders?${pairsOf(queryOf(said)).toString()}&format=csv`;
}

/** As an address has it: what is a list is said several times. */
export function pairsOf(query: Readonly<Record<string, unknown>>): URLSearchParams {
  return new URLSearchParams(
    Object.entries(query).flatMap(([name, value]) => (Array.isArray(value) ? value : [value]).map((each) => [name, String(each)])),
  );
}

/** In ISO 8601; null for what is no time. */
export function momentOf(said: string | undefined): string | null {
  const ms = new Date(said ?? "").getTime();
  return Number.isNaN(ms) ? null : new Date(ms).toISOString();
}

function statusesOf(said: string): Status[] {
  if (said === "open") return STATUSES.slice(0, 4);
  return STATUSES.filter((each) => each === said);
}
