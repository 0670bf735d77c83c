/** Which alerts of history the address asks for, and as the gateway is asked for them. Pure. */
import type { AlertsQuery } from "../../../api/client";
import { momentOf, pairsOf } from "../../orders/filter";
import type { Asked } from "../../views";

/** All that the gateway names (`gateway/live/views/alert.py`), graver ones first. */
export const KINDS = [
  "plant_behind", "no_strategist", "part_lost", "machine_lost", "machine_error", "station_lost", "gate_lost", "gate_error", "atv_lost", "atv_awaited", "atv_unplaced", "atv_unheard", "call_nobody", "call_unanswered",
  "atv_help", "atv_error", "jam", "order_impossible", "order_waits", "order_late", "overloaded", "machine_shut_out", "station_shut_out",
  "atv_shut_out", "strategist_lost", "machine_document", "machine_starved", "machine_blocked", "dock_fails", "dock_not_ready", "stock_unknown", "load_doubtful", "handover_disputed", "clock_wrong", "word_disbelieved",
  "strangers", "goods_stranded", "task_trouble", "atv_waits", "atv_promised", "atv_stopped", "atv_battery", "access_point", "atv_mesh",
] as const;
export const LEVELS = ["alarm", "warning"] as const;
export const STATES = ["lasting", "ended"] as const;

/** What the gateway is asked for: only what was filled in. */
export function queryOf(said: Asked): AlertsQuery {
  const kind = KINDS.find((each) => each === said.kind);
  const level = LEVELS.find((each) => each === said.level);
  const state = STATES.find((each) => each === said.state);
  const since = momentOf(said.since);
  const until = momentOf(said.until);
  return {
    ...(said.q ? { q: said.q } : {}),
    ...(kind ? { kind } : {}),
    ...(level ? { level } : {}),
    ...(state ? { state } : {}),
    ...(since === null ? {} : { since }),
    ...(until === null ? {} : { before: until }),
  };
}

/** The same alerts as a table for a spreadsheet, all of them. */
export function tableOf(said: Asked): string {
  return `/api/alerts/history?${pairsOf({ ...queryOf(said), format: "csv" }).toString()}`;
}
