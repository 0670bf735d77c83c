/** Which tasks the address asks for, and as the gateway is asked for them. Pure. */
import type { TasksQuery } from "../../../api/client";
import { momentOf, pairsOf } from "../../orders/filter";
import type { Asked } from "../../views";

export const STATES = ["bidding", "contracted", "delivered", "withdrawn"] as const;
const KINDS = ["transport", "production"] as const;
const SORTED = ["work", "opened", "promised", "late"] as const;

/** What the gateway is asked for: only what was filled in. Without an order of their own open ones come first. */
export function queryOf(said: Asked): TasksQuery {
  const state = STATES.filter((each) => each === said.state);
  const kind = KINDS.find((each) => each === said.kind);
  const since = momentOf(said.since);
  const until = momentOf(said.until);
  return {
    ...(said.q ? { q: said.q } : {}),
    ...(state.length > 0 ? { state } : {}),
    ...(kind ? { kind } : {}),
    ...(said.item ? { item: said.item } : {}),
    ...(said.late === "yes" ? { late: true } : {}),
    ...(since === null ? {} : { since }),
    ...(until === null ? {} : { before: until }),
    sort: SORTED.find((each) => each === said.sort) ?? "work",
    descending: said.down !== "no",
  };
}

/** The same tasks as a table for a spreadsheet, all of them. */
export function tableOf(said: Asked): string {
  return `/api/tasks/history?${pairsOf(queryOf(said)).toString()}&format=csv`;
}
