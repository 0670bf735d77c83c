/** The draft that is drawn: its content with what can be undone, its checks, and how it is kept at the gateway. */
import { batch, computed, signal } from "@preact/signals";
import { base64Of, type FileBody } from "../api/file-body";
import { bodyOf, gateway } from "../api/gateway";
import { Problem } from "../api/problem";
import type { components } from "../api/types";
import { begin, type History, redo, step, undo } from "./history";
import type { Chosen, Data, LISTS, Spot } from "./model";

type Draft = components["schemas"]["DraftView"];
export type DraftLine = components["schemas"]["DraftLine"];
export type Finding = components["schemas"]["FindingView"];
export type Play = components["schemas"]["PlayView"];

export const TOOLS = ["choose", "node", "lane", "road", "machines", "storages", "warehouses", "chargers", "parkings", "areas", "close"] as const;
export type Tool = (typeof TOOLS)[number];
export const KEYS: Record<Tool, string> = {
  choose: "V", node: "N", lane: "L", road: "R", machines: "M", storages: "S", warehouses: "W", chargers: "C", parkings: "P", areas: "A", close: "X",
};

/** So long after the last stroke a draft is kept and checked. */
const PAUSE_MS = 300;
const PLAY_EVERY_MS = 1000;

export const drafts = signal<readonly DraftLine[] | null>(null);
export const draft = signal<Omit<Draft, "data" | "findings"> | null>(null);
export const history = signal<History<Data>>(begin({}));
export const data = computed(() => history.value.now);
export const findings = signal<readonly Finding[]>([]);
export const running = signal<Data>({});
export const tool = signal<Tool>("choose");
export const chosen = signal<Chosen | null>(null);
/** The kind of drawn things of which one can be chosen by its name. */
export const kind = signal<string>("nodes");
/** The list that is filled in, and which of its entries. */
export const listed = signal<{ readonly section: (typeof LISTS)[number]; readonly index: number }>({ section: "materials", index: 0 });
/** The steps to the field that somebody was led to; null once it has been reached. */
export const wanted = signal<readonly string[] | null>(null);
/** Where a lane begins, or the corners of an area so far. */
export const begun = signal<readonly (Spot & { readonly node?: string })[]>([]);
export const cursor = signal<Spot>({ x_m: 0, y_m: 0 });
export const grid_m = signal(0.5);
export const shown = signal<"running" | "over" | "alone">("over");
export const kept = signal<"kept" | "keeping" | "changed" | "conflict" | "failed">("kept");
export const trouble = signal("");
/** What it would be like while something is being moved. */
export const ghost = signal<Data | null>(null);
/** Which picture lies under the draft, counted: its address stays. */
export const picture = signal(0);
export const play = signal<Play | null>(null);

export async function loadDrafts(): Promise<void> {
  drafts.value = (await bodyOf(gateway.GET("/api/plant-drafts", { params: { query: { limit: 200 } } }))).items;
}

export async function open(id: string): Promise<void> {
  const found = await bodyOf(gateway.GET("/api/plant-drafts/{draft}", { params: { path: { draft: id } } }));
  show(found);
  running.value = (await bodyOf(gateway.GET("/api/plant-drafts/running")));
  play.value = await bodyOf(gateway.GET("/api/plant-drafts/{draft}/play", { params: { path: { draft: id } } }));
  if (play.value.state === "playing") void follow(id);
}

function show(found: Draft): void {
  const { data: content, findings: said, ...rest } = found;
  batch(() => {
    draft.value = rest;
    history.value = begin<Data>(content);
    findings.value = said;
    kept.value = "kept";
    chosen.value = null;
    begun.value = [];
  });
  location.hash = found.id;
}

export async function create(name: string, file?: { body: FileBody; name: string; unit: string }, ontoRunning = false): Promise<void> {
  const content = file && ("text" in file.body ? { file: file.body.text } : { file_base64: file.body.base64 });
  const body = file ? { name, ...content, file_name: file.name, unit: file.unit, onto_running: ontoRunning } : { name };
  const made = await bodyOf(gateway.POST("/api/plant-drafts", { body: body as never }));
  await open(made.id);
}

export async function remove(id: string): Promise<void> {
  await gateway.DELETE("/api/plant-drafts/{draft}", { params: { path: { draft: id } } });
  await loadDrafts();
}

/** Draw something. */
export function draw(next: Data): void {
  if (next === data.value) return;
  history.value = step(history.value, next);
  keepSoon();
}

export function undoOne(): void {
  turn(undo(history.value));
}

export function redoOne(): void {
  turn(redo(history.value));
}

function turn(to: History<Data>): void {
  if (to.now === data.value) return;
  batch(() => {
    history.value = to;
    chosen.value = null;
    begun.value = [];
  });
  keepSoon();
}

let soon: number | undefined;
let keeping: Promise<void> = Promise.resolve();

function keepSoon(): void {
  if (kept.value !== "conflict") kept.value = "changed";
  clearTimeout(soon);
  soon = window.setTimeout(() => {
    keeping = keeping.then(keep);
  }, PAUSE_MS);
}

/** Keep what is drawn now; ends when it is kept. */
export async function keepNow(): Promise<void> {
  clearTimeout(soon);
  if (kept.value === "changed") keeping = keeping.then(keep);
  await keeping;
}

async function keep(): Promise<void> {
  const now = draft.value;
  const content = data.value;
  if (!now || kept.value === "conflict") return;
  kept.value = "keeping";
  try {
    const answer = await bodyOf(
      gateway.PUT("/api/plant-drafts/{draft}", {
        params: { path: { draft: now.id }, header: { "If-Match": `"${now.version}"` } },
        body: { name: now.name, data: content },
      }),
    );
    const { findings: said } = answer;
    batch(() => {
      draft.value = answer;
      findings.value = said;
      // Drawn on meanwhile: that is kept after this.
      kept.value = content === data.value ? "kept" : "changed";
    });
  } catch (error) {
    const conflict = error instanceof Problem && error.status === 412;
    kept.value = conflict ? "conflict" : "failed";
    trouble.value = error instanceof Problem ? error.message : String(error);
  }
}

export async function playShift(hours: number, seed: number): Promise<void> {
  await keepNow();
  const id = draft.value?.id;
  if (id === undefined) return;
  play.value = await bodyOf(gateway.POST("/api/plant-drafts/{draft}/play", { params: { path: { draft: id } }, body: { hours, seed } }));
  void follow(id);
}

async function follow(id: string): Promise<void> {
  while (draft.value?.id === id) {
    const now = await bodyOf(gateway.GET("/api/plant-drafts/{draft}/play", { params: { path: { draft: id } } }));
    play.value = now;
    if (now.state !== "playing") return;
    await new Promise((done) => setTimeout(done, PLAY_EVERY_MS));
  }
}

const DXF = "image/vnd.dxf";

export type Laid = components["schemas"]["PlanView"];

/** Lay a picture under the draft, or a floor plan in DXF, which the gateway makes one of. */
export async function layPlan(file: File): Promise<Laid | null> {
  const id = draft.value?.id;
  if (id === undefined) return null;
  const isDxf = /\.dxf$/i.test(file.name);
  const bytes = new Uint8Array(await (isDxf ? new Response(file.stream().pipeThrough(new CompressionStream("gzip"))) : file).arrayBuffer());
  const laid = await bodyOf(
    gateway.PUT("/api/plant-drafts/{draft}/plan", {
      params: { path: { draft: id } },
      body: { media_type: isDxf ? DXF : file.type, base64: base64Of(bytes) },
    }),
  );
  // Another picture at the same address is another one.
  picture.value += 1;
  draft.value = draft.value && { ...draft.value, plan_type: laid.media_type };
  return laid;
}
