/** What panels ask of the gateway. Each call ends with the answer's body, or with a `Problem`. */
import { csvOf, type FileBody } from "./file-body";
import { bodyOf, gateway } from "./gateway";
import { firstWord, stopOrigins } from "./stop-ways";
import type {
  CallAnswerRequest,
  ClosureRequest,
  CommandAnswer,
  CommandRequest,
  DutyRequest,
  DutyView,
  LoadSeenRequest,
  MachineCommandRequest,
  StationCommandRequest,
  FaultRequest,
  ImportAnswer,
  KpiHistory,
  LaneTraffic,
  MeAnswer,
  components,
  OrderAnswer,
  PlacedOrder,
  OrderDraft,
  OrderPreview,
  Outlook,
  PauseAnswer,
  PlantFile,
  PromiseLedger,
  QualityAnswer,
  WorkDraft,
  paths,
} from "./types";

/** The plant, and `plant_at_s` of it; null where the gateway does not tell it. */
export async function fetchPlant(): Promise<{ plant: PlantFile; atS: number | null }> {
  const call = gateway.GET("/api/plant");
  const plant = await bodyOf(call);
  const told = (await call).response.headers.get("Plant-At-S");
  return { plant, atS: told === null ? null : Number(told) };
}

/** What vehicles did on each lane, once per direction: since a moment, or within the last hour of factory time. */
export async function fetchTraffic(since?: string): Promise<LaneTraffic[]> {
  return (await bodyOf(gateway.GET("/api/traffic", { params: { query: since === undefined ? {} : { since } } }))).items;
}

/** How vehicles keep their promises. */
export async function fetchPromises(): Promise<PromiseLedger> {
  return await bodyOf(gateway.GET("/api/promises"));
}

type Query<Path extends keyof paths> = paths[Path] extends { get: { parameters: { query?: infer T } } } ? NonNullable<T> : never;

export type KpiStep = NonNullable<Query<"/api/kpis/history">["step"]>;

export async function fetchKpiHistory(sinceS: number, step: KpiStep): Promise<KpiHistory> {
  const since = new Date(sinceS * 1000).toISOString();
  return await bodyOf(gateway.GET("/api/kpis/history", { params: { query: { since, step } } }));
}

/** Good and bad pieces by machine and product, in whole hours. */
/** @param machine whose pieces; without it those of all */
export async function fetchQuality(sinceS: number, machine?: string): Promise<QualityAnswer> {
  const since = new Date(sinceS * 1000).toISOString();
  return await bodyOf(gateway.GET("/api/kpis/quality", { params: { query: { since, ...(machine === undefined ? {} : { machine: [machine] }) } } }));
}

/** @param key the same for every try at the same order: however often it is sent, it is placed once */
export async function placeOrder(order: OrderDraft, key: string): Promise<PlacedOrder> {
  return await bodyOf(gateway.POST("/api/orders", { body: order, params: { header: { "Idempotency-Key": key } } }));
}

export type OrdersQuery = Query<"/api/orders">;

/** Orders of all there ever were. */
export async function fetchOrders(query: OrdersQuery) {
  return await bodyOf(gateway.GET("/api/orders", { params: { query } }));
}

export type TasksQuery = Query<"/api/tasks/history">;
export type TaskRecord = components["schemas"]["TaskRecord"];

/** Tasks of all that are kept. */
export async function fetchTasks(query: TasksQuery) {
  return await bodyOf(gateway.GET("/api/tasks/history", { params: { query } }));
}

/** An order as it is kept, also one that the stream has forgotten. */
export async function fetchOrder(order: string): Promise<OrderAnswer> {
  return await bodyOf(gateway.GET("/api/orders/{order}", { params: { path: { order } } }));
}

/** What was made of an order and who carried it, what is expected of it, and its customer's links. */
export async function fetchTimeline(order: string): Promise<components["schemas"]["OrderStory"]> {
  return await bodyOf(gateway.GET("/api/orders/{order}/timeline", { params: { path: { order } } }));
}

/** Makes a link to the customer's page; its address is told this once. */
export async function makeLink(order: string): Promise<components["schemas"]["NewLink"]> {
  return await bodyOf(gateway.POST("/api/orders/{order}/links", { params: { path: { order } }, body: {} }));
}

/** Takes all links of an order back. */
export async function revokeLinks(order: string): Promise<void> {
  await bodyOf(gateway.DELETE("/api/orders/{order}/links", { params: { path: { order } } }));
}

export async function releaseOrder(order: string): Promise<void> {
  await bodyOf(gateway.POST("/api/orders/{order}/release", { params: { path: { order } } }));
}

/**
 * What is in a file of orders, and what is wrong with it by row.
 *
 * @param key the same for every try at the same file: however often it is sent, it is placed once
 */
export async function importOrders(file: FileBody, dryRun: boolean, key: string): Promise<ImportAnswer> {
  const header = dryRun ? {} : { "Idempotency-Key": key };
  return await bodyOf(gateway.POST("/api/orders/import", { body: { ...csvOf(file), dry_run: dryRun }, params: { header } }));
}

/** What an order would need if it were published now; nothing is kept. */
export async function previewOrder(order: WorkDraft): Promise<OrderPreview> {
  return await bodyOf(gateway.POST("/api/orders/preview", { body: order }));
}

/** Asks the factory to stop working at an order; it is stored again when the factory has confirmed. */
export async function revokeOrder(order: string): Promise<void> {
  await bodyOf(gateway.POST("/api/orders/{order}/revoke", { params: { path: { order } } }));
}

export type OrderChange = components["schemas"]["OrderChangeDraft"];

/** @param etag of the order as it was read: a change that somebody else has made since is not overwritten */
export async function changeOrder(order: string, change: OrderChange, etag: string): Promise<OrderAnswer> {
  return await bodyOf(gateway.PATCH("/api/orders/{order}", { params: { path: { order }, header: { "If-Match": etag } }, body: change }));
}

export async function cancelOrder(order: string): Promise<void> {
  await bodyOf(gateway.POST("/api/orders/{order}/cancel", { params: { path: { order } } }));
}

/** Sends a command; a stop goes all the ways there are at once, and counts once by its name. */
export async function commandAtv(atv: string, command: CommandRequest): Promise<CommandAnswer> {
  const params = { path: { atv } };
  if (command.kind !== "stop") {
    return await bodyOf(gateway.POST("/api/atvs/{atv}/commands", { params, body: command }));
  }
  const body = { command: newKey(), ...command };
  return await firstWord(["", ...stopOrigins()], (origin) => {
    // The way for stops is another origin on the same host.
    const way = origin === "" ? {} : { baseUrl: origin, credentials: "include" as const };
    return bodyOf(gateway.POST("/api/atvs/{atv}/commands", { ...way, params, body }));
  });
}

/** Sends a command to a machine. */
export async function commandMachine(machine: string, command: MachineCommandRequest): Promise<CommandAnswer> {
  return await bodyOf(gateway.POST("/api/machines/{machine}/commands", { params: { path: { machine } }, body: command }));
}

/** Says what has happened at a station that people work. */
export async function commandStation(station: string, command: StationCommandRequest): Promise<CommandAnswer> {
  return await bodyOf(gateway.POST("/api/stations/{station}/commands", { params: { path: { station } }, body: command }));
}

/** Says what somebody has seen of a load that is perhaps there and not counted. */
export async function loadSeen(task: string, seen: LoadSeenRequest): Promise<CommandAnswer> {
  return await bodyOf(gateway.POST("/api/tasks/{task}/load", { params: { path: { task } }, body: seen }));
}

/** Ends the session of this browser. Not by a form: on pages without a referrer it would not tell where it comes from. */
export async function logOut(): Promise<void> {
  await gateway.POST("/logout");
}

/** Who is logged in here. */
export async function fetchMe(): Promise<MeAnswer> {
  return await bodyOf(gateway.GET("/api/me"));
}

export type AuditQuery = Query<"/api/audit">;

export async function fetchAudit(query: AuditQuery) {
  return await bodyOf(gateway.GET("/api/audit", { params: { query } }));
}

/** Whether one is on duty, who else is, and who calls for help; to ask is to be there. */
export async function fetchDuty(): Promise<DutyView> {
  return await bodyOf(gateway.GET("/api/duty"));
}

/** Goes on duty, has a break, or goes off duty. */
export async function putDuty(duty: DutyRequest): Promise<DutyView> {
  return await bodyOf(gateway.PUT("/api/duty", { body: duty }));
}

/** Answers a call for help; returns whether one is expected there. */
export async function answerCall(call: string, answer: CallAnswerRequest): Promise<boolean> {
  return (await bodyOf(gateway.POST("/api/calls/{call}/answer", { params: { path: { call } }, body: answer }))).expected;
}

/** Says by one's own name that an alert is in good hands, until when (null for as long as it lasts), and why. */
export async function acknowledgeAlert(alert: string, comment = "", untilAtS: number | null = null): Promise<void> {
  const until_at = untilAtS === null ? null : new Date(untilAtS * 1000).toISOString();
  await bodyOf(gateway.POST("/api/alerts/{alert}/acknowledge", { params: { path: { alert } }, body: { comment, until_at } }));
}

export type AlertsQuery = Query<"/api/alerts/history">;
export type AlertRecord = components["schemas"]["AlertRecord"];

/** Alerts of all that are kept. */
export async function fetchAlerts(query: AlertsQuery) {
  return await bodyOf(gateway.GET("/api/alerts/history", { params: { query } }));
}

/** Lets nobody hear an agent any more, until it is readmitted. */
export async function shutOut(agent: string, reason: string): Promise<void> {
  await bodyOf(gateway.POST("/api/agents/{agent}/shut-out", { params: { path: { agent } }, body: { reason } }));
}

/** Closes a lane, a place or an area to vehicles, or makes it slow or one-way. */
export async function closeFloor(closure: ClosureRequest): Promise<void> {
  await bodyOf(gateway.POST("/api/closures", { body: closure }));
}

/** What a closure would cut off, and whom it would shut in. */
export async function previewClosure(closure: ClosureRequest): Promise<Outlook> {
  return await bodyOf(gateway.POST("/api/closures/preview", { body: closure }));
}

/** Pauses an area: nobody drives into it, and all vehicles in it stop. */
export async function pauseArea(area: string, reason: string): Promise<PauseAnswer> {
  return await bodyOf(gateway.POST("/api/areas/{area}/pause", { params: { path: { area } }, body: { reason } }));
}

/** Opens it, and lets those go on that its pause has stopped. */
export async function letAreaGoOn(area: string): Promise<PauseAnswer> {
  return await bodyOf(gateway.POST("/api/areas/{area}/go-on", { params: { path: { area } } }));
}

export async function endClosure(closure: string): Promise<void> {
  await bodyOf(gateway.DELETE("/api/closures/{closure}", { params: { path: { closure } } }));
}

/** Says that nothing lies on a lane any more. */
export async function clearObstacle(start: string, end: string): Promise<void> {
  await bodyOf(gateway.POST("/api/obstacles/cleared", { body: { start, end } }));
}

/** Says that a vehicle is off the floor. */
export async function carryAway(atv: string): Promise<void> {
  await bodyOf(gateway.POST("/api/atvs/{atv}/carried-away", { params: { path: { atv } }, body: { off_the_floor: true } }));
}

/** Has a place kept to which a vehicle is being put back. */
export async function putBack(atv: string, place: string): Promise<void> {
  await bodyOf(gateway.POST("/api/atvs/{atv}/put-back", { params: { path: { atv } }, body: { place } }));
}

export async function readmit(agent: string): Promise<void> {
  await bodyOf(gateway.POST("/api/agents/{agent}/readmit", { params: { path: { agent } } }));
}

/** @param fault for the simulated factory, as data; `kind` says which fields it has */
export async function beginFault(fault: FaultRequest): Promise<void> {
  await bodyOf(gateway.POST("/api/faults", { body: fault }));
}

export async function endFault(fault: string): Promise<void> {
  await bodyOf(gateway.DELETE("/api/faults/{fault}", { params: { path: { fault } } }));
}

/** Lets the factory run as fast as it can until the next step of its scenario, or no longer. */
export async function skipToNextStep(skips: boolean): Promise<void> {
  await bodyOf(skips ? gateway.POST("/api/scenario/skip") : gateway.DELETE("/api/scenario/skip"));
}

/** An idempotency key; also where the page is not on HTTPS and `randomUUID` is missing. */
export function newKey(): string {
  const bytes = crypto.getRandomValues(new Uint8Array(16));
  return Array.from(bytes, (byte) => byte.toString(16).padStart(2, "0")).join("");
}
