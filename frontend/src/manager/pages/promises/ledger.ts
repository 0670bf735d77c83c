/** The promise ledger as a sorted table. Pure. */
import type { PromiseLine } from "../../../api/types";

/** The columns, in the order in which they are shown. */
export const COLUMNS = ["vehicle", "delivered", "onTime", "median", "p95", "worst", "lost", "last"] as const;
export type Column = (typeof COLUMNS)[number];

export interface Order {
  readonly column: Column;
  readonly descending: boolean;
}

/** Whoever keeps its promises worst comes first: that is what one looks for. */
export const AT_FIRST: Order = { column: "p95", descending: true };

const names = new Intl.Collator("en", { numeric: true });

export function sorted(lines: readonly PromiseLine[], { column, descending }: Order): PromiseLine[] {
  const sign = descending ? -1 : 1;
  return [...lines].sort((a, b) => {
    const first = valueOf(a, column);
    const second = valueOf(b, column);
    // What nobody knows comes last, whichever way the table is sorted.
    if (first === null || second === null) return Number(first === null) - Number(second === null) || byName(a, b);
    return sign * (column === "vehicle" ? byName(a, b) : first - second) || byName(a, b);
  });
}

/** A click on the same column turns it round; another one begins where the interesting end is. */
export function next(order: Order, column: Column): Order {
  if (order.column === column) return { column, descending: !order.descending };
  return { column, descending: column !== "vehicle" && column !== "onTime" };
}

function byName(a: PromiseLine, b: PromiseLine): number {
  return names.compare(a.atv, b.atv);
}

function valueOf(line: PromiseLine, column: Column): number | null {
  switch (column) {
    case "vehicle":
      return 0;
    case "delivered":
      return line.delivered;
    case "onTime":
      return line.on_time_frac;
    case "median":
      return line.median_s;
    case "p95":
      return line.p95_s;
    case "worst":
      return line.worst_s;
    case "lost":
      return line.lost;
    case "last":
      return line.last_at_s;
  }
}
