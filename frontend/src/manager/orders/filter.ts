/** Which orders the address asks for, and as the gateway is asked for them. Pure. */
import type { OrdersQuery } from "../../api/client";
import type { Asked } from "../views";

export const STATUSES = ["stored", "released", "in_production", "in_delivery", "delivered", "cancelled"] as const;
type Status = (typeof STATUSES)[number];

const SORTED = ["work", "reference", "customer", "due", "created"] as const;

/** What the gateway is asked for: only what was filled in. Without an order of their own they come as people work at them. */
export function queryOf(said: Asked): OrdersQuery {
  const sort = SORTED.find((each) => each === said.sort) ?? "work";
  const since = dayOf(said.since);
  const until = dayOf(said.until, 1);
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

/** A day as 2030-06-03; what comes after it does not count. */
const DAY = /^(\d{4})-(\d\d)-(\d\d)/;

/** The last moment that ISO 8601 and the gateway can name: the end of the year 9999. */
export const LAST_S = 253_402_300_799;

/** In ISO 8601; null for what is no time. */
export function momentOf(said: string | undefined): string | null {
  return isoOf(new Date(said ?? ""));
}

/**
 * When a day of the reader's zone begins, in ISO 8601; null for what is no day.
 *
 * @param said a day, as 2030-06-03; a time after it does not count
 * @param later so many days later
 */
export function dayOf(said: string | undefined, later = 0): string | null {
  const [year = NaN, month = NaN, date = NaN] = DAY.exec(said ?? "")?.slice(1).map(Number) ?? [];
  const day = beginOf(year, month, date);
  return day.getMonth() + 1 === month && day.getDate() === date ? isoOf(beginOf(year, month, date + later)) : null;
}

/** The first moment of a day. Not each has a midnight: where clocks change at midnight, one begins at 01:00. */
function beginOf(year: number, month: number, date: number): Date {
  const day = new Date(2000, 0, 1);
  // Unlike the constructor it takes a year below 100 as it is.
  day.setFullYear(year, month - 1, date);
  return day;
}

/** Nothing was before 1970, and a year that is still being typed is no fault. */
function isoOf(at: Date): string | null {
  const ms = at.getTime();
  return Number.isNaN(ms) ? null : new Date(Math.min(Math.max(ms, 0), LAST_S * 1000)).toISOString();
}

function statusesOf(said: string): Status[] {
  if (said === "open") return STATUSES.slice(0, 4);
  return STATUSES.filter((each) => each === said);
}
