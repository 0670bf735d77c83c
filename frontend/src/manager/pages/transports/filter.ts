/** Which plain transports the address asks for, and as the gateway is asked for them. Pure. */
import type { TransportAnswer, TransportState } from "../../../api/transports";
import { pairsOf } from "../../orders/filter";
import type { Asked } from "../../views";

export const STATES = ["waiting", "assigned", "on_board", "delivered", "cancelled"] as const satisfies readonly TransportState[];
const OPEN: readonly TransportState[] = ["waiting", "assigned", "on_board"];

const SORTED = ["called", "due"] as const;

export interface TransportsQuery {
  readonly q?: string;
  readonly status?: TransportState[];
  readonly place?: string;
  readonly sort: (typeof SORTED)[number];
  readonly descending: boolean;
}

export function queryOf({ down, place, q, sort, state }: Asked): TransportsQuery {
  const one = STATES.filter((each) => each === state);
  const status = state === "open" ? [...OPEN] : one;
  return { ...(q ? { q } : {}), ...(status.length > 0 ? { status } : {}), ...(place ? { place } : {}), sort: SORTED.find((each) => each === sort) ?? "called", descending: down !== "no" };
}

/** The same transports as a table for a spreadsheet, all of them. */
export function tableOf(said: Asked): string {
  return `/api/transports?${pairsOf({ ...queryOf(said) }).toString()}&format=csv`;
}

/** Whether it can be called off: not once it is on board, and not twice. */
export function canCallOff({ cancel_at, status }: TransportAnswer): boolean {
  return (status === "waiting" || status === "assigned") && cancel_at === null;
}
