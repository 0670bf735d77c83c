/** Which lines of the audit log are wanted, as a person fills it in, and as the gateway is asked for them. Pure. */
import type { AuditQuery } from "../../../api/client";
import { LAST_S } from "../../orders/filter";
import type { Asked } from "../../views";

export interface Filter {
  /** Words of which each must stand somewhere in a line. */
  readonly q: string;
  /** As a field of date and time has it, in the reader's zone; empty for no bound. */
  readonly since: string;
  readonly until: string;
  readonly who: string;
  readonly action: string;
  readonly target: string;
  readonly result: string;
}

export const NOTHING: Filter = { q: "", since: "", until: "", who: "", action: "", target: "", result: "" };

/** What the address asks for. */
export function filterFrom(said: Asked): Filter {
  return Object.fromEntries(Object.keys(NOTHING).map((name) => [name, said[name] ?? ""])) as unknown as Filter;
}

/** All that the gateway names (`gateway/access/rules.py`). */
export const ACTIONS = [
  "vehicle.command", "vehicle.carry_away", "vehicle.put_back", "machine.command", "station.command", "load.see", "call.answer", "duty.set", "alert.acknowledge",
  "order.place", "order.import", "order.release", "order.revoke", "order.change", "order.cancel", "transport.call", "transport.cancel",
  "product.define", "product.remove", "product.remove_several", "product.import", "link.create", "link.revoke", "floor.close", "floor.open", "area.pause", "area.go_on", "floor.cleared", "agent.shut_out", "agent.readmit",
  "draft.begin", "draft.change", "draft.plan", "draft.play", "draft.remove", "report.targets", "schedule.add", "schedule.change", "schedule.remove", "fault.begin", "fault.end", "scenario.skip", "scenario.skip_end",
  "login", "login.station", "logout", "user.add", "user.link", "user.secret", "user.password", "user.pin", "user.badge", "user.move", "user.disable", "user.enable", "key.create", "key.revoke",
] as const;
export const RESULTS = ["done", "refused", "failed"] as const;

/** What the gateway is asked for: only what was filled in. */
export function queryOf({ action, q, result, since, target, until, who }: Filter): AuditQuery {
  const all = { q: q.trim(), since: secondsOf(since), until: secondsOf(until), who: who.trim(), action, target: target.trim(), result };
  return Object.fromEntries(Object.entries(all).filter(([, value]) => value !== "" && !Number.isNaN(value)));
}

/** Where the same lines are as a table, all of them. */
export function tableOf(filter: Filter, oldestFirst = false): string {
  const query = { ...queryOf(filter), ...(oldestFirst ? { oldest_first: true } : {}) };
  const given = Object.entries(query).map(([name, value]) => [name, String(value)]);
  return `/api/audit?${new URLSearchParams([...given, ["format", "csv"]]).toString()}`;
}

function secondsOf(moment: string): number {
  return Math.min(Math.max(new Date(moment).getTime() / 1000, 0), LAST_S);
}
