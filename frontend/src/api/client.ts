/** Requests to the gateway, with its problems (RFC 9457) as values. */
import { tellLoggedOut } from "./session";
import { firstWord, stopOrigins } from "./stop-ways";
import type { KpiHistory, OrderPreview, PlantFile } from "./types";

export interface FieldError {
  readonly field: string;
  readonly reason: string;
}

/** The kind of a problem with `status` 0 where there was no way to the gateway at all. */
export const NOT_SENT = "not-sent";

/** Why a request did not succeed. `status` 0: no answer came. */
export class Problem extends Error {
  constructor(
    readonly status: number,
    title: string,
    readonly errors: readonly FieldError[] = [],
    /** Its short name, as `unknown-order`; empty where the answer has none. */
    readonly kind = "",
  ) {
    super(title);
    this.name = "Problem";
  }
}

export interface NewOrder {
  customer: string;
  items: { product: string; quantity: number }[];
  due_at?: string;
  reference?: string;
  release: boolean;
}

export interface PlacedOrder {
  id: string;
  status: string;
}

/** Longer than the gateway ever needs to write an order down. */
const PATIENCE_MS = 10_000;

export async function fetchPlant(): Promise<PlantFile> {
  return (await request("GET", "/api/plant")) as PlantFile;
}

/** How often each lane was passed within the last hour of factory time, once per direction. */
export async function fetchTraffic(): Promise<{ start: string; end: string; passes: number }[]> {
  const answer = (await request("GET", "/api/traffic")) as { items: { start: string; end: string; passes: number }[] };
  return answer.items;
}

/** How a vehicle keeps its promises; in factory seconds, below 0 for earlier than promised. */
export interface PromiseLine {
  /** Empty for the whole fleet. */
  readonly atv: string;
  readonly delivered: number;
  readonly on_time: number;
  readonly on_time_frac: number | null;
  readonly median_s: number | null;
  readonly p95_s: number | null;
  readonly worst_s: number | null;
  readonly worst_task: string;
  /** Transports that somebody else had to carry on. */
  readonly lost: number;
  readonly last_at_s: number | null;
}

export interface PromiseLedger {
  readonly on_time_within_s: number;
  readonly fleet: PromiseLine;
  readonly items: readonly PromiseLine[];
}

export async function fetchPromises(): Promise<PromiseLedger> {
  return (await request("GET", "/api/promises")) as PromiseLedger;
}

/** @param stepS one of the lengths that the gateway offers */
export async function fetchKpiHistory(sinceS: number, stepS: number): Promise<KpiHistory> {
  const since = new Date(sinceS * 1000).toISOString();
  return (await request("GET", `/api/kpis/history?since=${since}&step=${stepS}`)) as KpiHistory;
}

/** @param key the same for every try at the same order: however often it is sent, it is placed once */
export async function placeOrder(order: NewOrder, key: string): Promise<PlacedOrder> {
  return (await request("POST", "/api/orders", order, { "Idempotency-Key": key })) as PlacedOrder;
}

export async function releaseOrder(id: string): Promise<void> {
  await request("POST", `/api/orders/${encodeURIComponent(id)}/release`);
}

/** What is in a file of orders, and what is wrong with it by row. */
export interface OrdersFile {
  readonly orders: readonly { readonly id: string; readonly customer: string; readonly pieces: number }[];
  readonly faults: readonly { readonly row: number; readonly column: string; readonly reason: string }[];
}

/** @param key the same for every try at the same file: however often it is sent, it is placed once */
export async function importOrders(csv: string, dryRun: boolean, key: string): Promise<OrdersFile> {
  const headers: Record<string, string> = dryRun ? {} : { "Idempotency-Key": key };
  return (await request("POST", "/api/orders/import", { csv, dry_run: dryRun }, headers)) as OrdersFile;
}

/** What an order would need if it were published now; nothing is kept. */
export async function previewOrder(order: Pick<NewOrder, "items" | "due_at">): Promise<OrderPreview> {
  return (await request("POST", "/api/orders/preview", order)) as OrderPreview;
}

/** Asks the factory to stop working at an order; it is stored again when the factory has confirmed. */
export async function revokeOrder(id: string): Promise<void> {
  await request("POST", `/api/orders/${encodeURIComponent(id)}/revoke`);
}

export async function cancelOrder(id: string): Promise<void> {
  await request("POST", `/api/orders/${encodeURIComponent(id)}/cancel`);
}

/** What a person asks of a vehicle. */
export interface CommandRequest {
  /** The caller's own name for it, by which the stream tells of it. */
  readonly command?: string;
  readonly kind: "stop" | "acknowledge" | "resume" | "set_speed" | "promise";
  /** Of `set_speed`: a part of the vehicle's own top speed. */
  readonly speed_frac?: number;
  /** Of `promise`: until help is there, in factory seconds. */
  readonly wait_s?: number;
}

/** The vehicle's word on it. */
export interface CommandAnswer {
  readonly done: boolean;
  /** Why it was refused; empty when it was done. */
  readonly reason: string;
}

/** Sends a command; a stop goes all the ways there are at once, and counts once by its name. */
export async function commandAtv(atv: string, command: CommandRequest): Promise<CommandAnswer> {
  const path = `/api/atvs/${encodeURIComponent(atv)}/commands`;
  if (command.kind !== "stop") return (await request("POST", path, command)) as CommandAnswer;
  const named = { command: newKey(), ...command };
  return await firstWord([path, ...stopOrigins().map((origin) => origin + path)], (way) =>
    request("POST", way, named) as Promise<CommandAnswer>,
  );
}

/** Ends the session of this browser. Not by a form: on pages without a referrer it would not tell where it comes from. */
export async function logOut(): Promise<void> {
  await request("POST", "/logout");
}

/** Who is logged in here. */
export interface Me {
  /** person, key or admin. */
  readonly kind: string;
  readonly name: string;
  /** Of a person: manager or operator. */
  readonly role: string | null;
  /** Ids; null for the whole plant. */
  readonly areas: readonly string[] | null;
  /** The machine at which an operator works; empty where that matters nothing. */
  readonly station: string;
  readonly expires_at_s: number | null;
}

export async function fetchMe(): Promise<Me> {
  return (await request("GET", "/api/me")) as Me;
}

export interface AuditLine {
  readonly position: number;
  readonly at_s: number;
  readonly who: string;
  /** person, key, admin, console or nobody. */
  readonly who_kind: string;
  readonly from_ip: string;
  readonly action: string;
  readonly target: string;
  readonly result: string;
  readonly detail: Readonly<Record<string, unknown>>;
}

export interface AuditPage {
  /** Newest first. */
  readonly items: readonly AuditLine[];
  readonly next_cursor: string | null;
}

export async function fetchAudit(query: string): Promise<AuditPage> {
  return (await request("GET", `/api/audit?${query}`)) as AuditPage;
}

/** Says by one's own name that an alert is in good hands. */
export async function acknowledgeAlert(id: string): Promise<void> {
  await request("POST", `/api/alerts/${encodeURIComponent(id)}/acknowledge`);
}

/** Lets nobody hear an agent any more, until it is readmitted. */
export async function shutOut(agent: string, reason: string): Promise<void> {
  await request("POST", `/api/agents/${encodeURIComponent(agent)}/shut-out`, { reason });
}

export async function readmit(agent: string): Promise<void> {
  await request("POST", `/api/agents/${encodeURIComponent(agent)}/readmit`);
}

/** A fault for the simulated factory, as data; `kind` says which fields it has. */
export type NewFault = Readonly<Record<string, string | number>> & { readonly kind: string };

export async function beginFault(fault: NewFault): Promise<void> {
  await request("POST", "/api/faults", fault);
}

export async function endFault(id: string): Promise<void> {
  await request("DELETE", `/api/faults/${encodeURIComponent(id)}`);
}

async function request(
  method: string,
  path: string,
  body?: unknown,
  headers: Record<string, string> = {},
): Promise<unknown> {
  const sent = body === undefined ? {} : { "Content-Type": "application/json" };
  const init: RequestInit = {
    method,
    // The way for stops is another origin on the same host.
    credentials: path.startsWith("/") ? "same-origin" : "include",
    headers: { Accept: "application/json", ...sent, ...headers },
    signal: AbortSignal.timeout(PATIENCE_MS),
    body: body === undefined ? null : JSON.stringify(body),
  };
  const response = await fetch(path, init).catch((error: unknown) => {
    // Browsers do not tell a connection that was refused from one that was cut: only patience that has ended is told.
    const late = error instanceof DOMException && error.name === "TimeoutError";
    throw new Problem(0, "", [], late ? "" : NOT_SENT);
  });
  const answer: unknown = await response.json().catch(() => null);
  // Who is known at the way for stops is known from memory: only the gateway itself says who is logged in.
  if (response.status === 401 && path.startsWith("/")) tellLoggedOut();
  if (!response.ok) throw problemOf(response.status, answer);
  return answer;
}

/** Whatever the answer holds, it becomes a problem: a proxy may send HTML. */
export function problemOf(status: number, answer: unknown): Problem {
  const body = (typeof answer === "object" && answer !== null ? answer : {}) as Record<string, unknown>;
  const title = [body.detail, body.title].find((text) => typeof text === "string" && text !== "");
  const errors = Array.isArray(body.errors) ? body.errors.filter(isFieldError) : [];
  const kind = typeof body.type === "string" ? (body.type.split(":").at(-1) ?? "") : "";
  return new Problem(status, typeof title === "string" ? title : `HTTP ${status}`, errors, kind);
}

function isFieldError(value: unknown): value is FieldError {
  const error = value as Partial<Record<string, unknown>> | null;
  return typeof error?.field === "string" && typeof error.reason === "string";
}

/** An idempotency key; also where the page is not on HTTPS and `randomUUID` is missing. */
export function newKey(): string {
  const bytes = crypto.getRandomValues(new Uint8Array(16));
  return Array.from(bytes, (byte) => byte.toString(16).padStart(2, "0")).join("");
}
