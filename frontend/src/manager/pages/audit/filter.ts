/** Which lines of the audit log are wanted, as a person fills it in, and as the gateway is asked for them. Pure. */
import type { AuditQuery } from "../../../api/client";

export interface Filter {
  /** As a field of date and time has it, in the reader's zone; empty for no bound. */
  readonly since: string;
  readonly until: string;
  readonly who: string;
  readonly action: string;
  readonly target: string;
  readonly result: string;
}

export const NOTHING: Filter = { since: "", until: "", who: "", action: "", target: "", result: "" };

/** All that the gateway names (`gateway/access/rules.py`). */
export const ACTIONS = [
  "vehicle.command", "vehicle.carry_away", "vehicle.put_back", "machine.command", "call.answer", "duty.set", "alert.acknowledge",
  "order.place", "order.import", "order.release", "order.revoke", "order.cancel", "transport.call", "transport.cancel",
  "product.define", "link.create", "link.revoke", "floor.close", "floor.open", "floor.cleared", "agent.shut_out", "agent.readmit",
  "draft.begin", "draft.change", "draft.plan", "draft.play", "draft.remove", "fault.begin", "fault.end",
  "login", "login.station", "logout",
] as const;
export const RESULTS = ["done", "refused", "failed"] as const;

/** What the gateway is asked for: only what was filled in. */
export function queryOf({ action, result, since, target, until, who }: Filter): AuditQuery {
  const all = { since: secondsOf(since), until: secondsOf(until), who: who.trim(), action, target: target.trim(), result };
  return Object.fromEntries(Object.entries(all).filter(([, value]) => value !== "" && !Number.isNaN(value)));
}

/** Where the same lines are as a table, all of them. */
export function tableOf(filter: Filter): string {
  const given = Object.entries(queryOf(filter)).map(([name, value]) => [name, String(value)]);
  return `/api/audit?${new URLSearchParams([...given, ["format", "csv"]]).toString()}`;
}

/** What a line tells beyond its columns, in one line of text. */
export function detailText(detail: Readonly<Record<string, unknown>>): string {
  return Object.entries(detail)
    .map(([name, value]) => `${name} ${plain(value)}`)
    .join(" · ");
}

function plain(value: unknown): string {
  if (Array.isArray(value)) return value.map(plain).join(", ");
  return typeof value === "string" ? value : JSON.stringify(value);
}

function secondsOf(moment: string): number {
  return new Date(moment).getTime() / 1000;
}
