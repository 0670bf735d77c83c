/** Which lines of the audit log are wanted, as a person fills it in, and as the gateway is asked for them. Pure. */

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

export const ACTIONS = [
  "vehicle.command", "alert.acknowledge", "order.place", "order.release", "order.revoke", "order.cancel",
  "fault.begin", "fault.end", "login", "login.station", "logout",
] as const;
export const RESULTS = ["done", "refused", "failed"] as const;

/** @param more parameters beside the filter's: `cursor`, `limit` or `format` */
export function queryOf(filter: Filter, more: Readonly<Record<string, string>> = {}): string {
  const { action, result, since, target, until, who } = filter;
  const all = { since: secondsOf(since), until: secondsOf(until), who: who.trim(), action, target: target.trim(), result, ...more };
  const given = Object.entries(all).filter(([, value]) => value !== "");
  return new URLSearchParams(given).toString();
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

function secondsOf(moment: string): string {
  const ms = new Date(moment).getTime();
  return Number.isNaN(ms) ? "" : String(ms / 1000);
}
