/** Lists of the plant file that are filled in as forms: which columns an entry has, and of what each is chosen. Pure. */
import { type Data, entries, nodesOf } from "./model";

export type Row = Readonly<Record<string, unknown>>;

export interface Column {
  readonly name: string;
  readonly kind: "text" | "count" | "number" | "words" | "lines" | "time" | "days" | "choice" | "rows";
  /** What an entry does without: left empty it is not in the file. */
  readonly optional?: true;
  /** Under which it is called, where that is not its name. */
  readonly label?: string;
  /** Of a choice: what can be chosen. */
  readonly from?: (data: Data) => readonly string[];
  /** Of a new row: what stands there. */
  readonly begins?: unknown;
  /** Of rows: the columns of each. */
  readonly columns?: readonly Column[];
}

const ids = (data: Data, section: string): readonly string[] => entries<{ id?: unknown } | null>(data, section).flatMap((each) => (typeof each?.id === "string" ? [each.id] : []));

/** What a bill can name: materials, and products that are parts. */
const used = (data: Data): readonly string[] => [
  ...ids(data, "materials"),
  ...entries<{ id?: unknown; buffer?: unknown } | null>(data, "products").flatMap((each) => (typeof each?.id === "string" && Number(each.buffer) > 0 ? [each.id] : [])),
];

const text = (name: string): Column => ({ name, kind: "text" });
const count = (name: string): Column => ({ name, kind: "count" });
const number = (name: string): Column => ({ name, kind: "number" });
const choice = (name: string, from: (data: Data) => readonly string[]): Column => ({ name, kind: "choice", from });
const time = (name: string, begins: string): Column => ({ name, kind: "time", begins });
const node = (name: string): Column => choice(name, (data) => nodesOf(data).map(({ id }) => id));
const optional = (column: Column): Column => ({ ...column, optional: true });

export const DAYS = ["mon", "tue", "wed", "thu", "fri", "sat", "sun"] as const;
const WEEKDAYS = DAYS.slice(0, 5);

/** A part of some days of every week; without days it is one of every day. */
const span = (start: string, end: string): readonly Column[] => [time("start", start), time("end", end), { name: "days", kind: "days", optional: true, begins: WEEKDAYS }];

/** By section, or by the field of an entry. */
export const COLUMNS: Readonly<Record<string, readonly Column[]>> = {
  materials: [text("id"), text("name"), count("lot"), count("buffer"), optional(text("ability"))],
  products: [
    text("id"), text("name"), count("lot"), optional(count("buffer")), optional(text("ability")),
    { name: "bill", kind: "rows", columns: [choice("material", used), count("quantity")] },
  ],
  stations: [text("id"), text("name")],
  vehicle_types: [
    text("id"), text("name"),
    ...["length_m", "width_m", "max_speed_mps", "acceleration_mps2", "turn_speed_mps"].map((name) => optional(number(name))),
    optional({ name: "abilities", kind: "words" }),
    ...["load_s", "unload_s", "battery_wh", "drive_wh_per_m", "loaded_wh_per_m", "idle_w", "charge_w"].map((name) => optional(number(name))),
  ],
  fleet: [text("id"), choice("type", (data) => ids(data, "vehicle_types")), node("node"), optional(number("battery_frac"))],
  types: [choice("type", (data) => ids(data, "vehicle_types")), optional(number("speed_limit_mps"))],
  lanes: [node("start"), node("end")],
  polygon: [{ ...number("x_m"), label: "corner_x_m" }, { ...number("y_m"), label: "corner_y_m" }],
  working_time: [
    { name: "shifts", kind: "rows", columns: span("06:00", "14:00") },
    { name: "breaks", kind: "rows", columns: span("09:00", "09:15"), optional: true },
    optional({ name: "holidays", kind: "words" }),
  ],
  max_vehicle: [number("length_m"), number("width_m")],
  originals: [{ name: "originals", kind: "lines" }],
  makes: [choice("product", (data) => ids(data, "products")), number("cycle_s"), optional(number("scrap_frac")), optional(number("cycle_cv"))],
};

/** Fields of what is drawn that name something else of the plant. */
export const REFERS: Readonly<Record<string, (data: Data) => readonly string[]>> = {
  station: (data) => ids(data, "stations"),
  node: (data) => nodesOf(data).map(({ id }) => id),
  start: (data) => nodesOf(data).map(({ id }) => id),
  end: (data) => nodesOf(data).map(({ id }) => id),
};

/** The rows of a list; none where nobody has said any, null for what is no list of them. */
export function rowsOf(value: unknown): readonly Row[] | null {
  if (value === undefined || value === null) return [];
  const isList = Array.isArray(value) && value.every((each) => typeof each === "object" && each !== null && !Array.isArray(each));
  return isList ? (value as Row[]) : null;
}

/** What stands together in a field; empty where nobody has said any of it, null for what is something else. */
export function rowOf(value: unknown): Row | null {
  if (value === undefined || value === null) return {};
  return typeof value === "object" && !Array.isArray(value) ? (value as Row) : null;
}

/** Lines of text; none where nobody has said any, null for what is something else. */
export function linesOf(value: unknown): readonly string[] | null {
  if (value === undefined || value === null) return [];
  return Array.isArray(value) && value.every((each) => typeof each === "string") ? value : null;
}

/** What a column says that somebody has filled in; undefined for nothing. A number that is none stays as it was written, for the checks. */
export function valueOf(column: Column, written: string): unknown {
  const said = written.trim();
  if (said === "") return undefined;
  if (column.kind === "lines") return said.split("\n").map((line) => line.trim()).filter(Boolean);
  if (column.kind === "words") return said.split(/[\s,]+/).filter(Boolean);
  if (column.kind !== "count" && column.kind !== "number") return said;
  const figure = Number(said.replace(",", "."));
  return Number.isFinite(figure) ? figure : said;
}

/** A value as it stands in a field; nothing for what nobody has said. */
export function writtenOf(value: unknown): string {
  if (Array.isArray(value)) return value.filter((each) => typeof each === "string").join(", ");
  return typeof value === "string" || typeof value === "number" ? String(value) : "";
}

/** A row with one column otherwise: what is left empty is not in the file, unless it has to be said, and then it is open. */
export function withValue(row: Row, column: Column, value: unknown): Row {
  if (value === undefined && column.optional) return Object.fromEntries(Object.entries(row).filter(([name]) => name !== column.name));
  return { ...row, [column.name]: value ?? null };
}

/** One row more: what it is chosen of is the first thing that no other row has; the rest is open. */
export function withRow(data: Data, columns: readonly Column[], rows: readonly Row[], begins: string): readonly Row[] {
  const made: Record<string, unknown> = {};
  for (const column of columns) {
    if (column.begins !== undefined) made[column.name] = column.begins;
    if (column.optional || column.begins !== undefined) continue;
    if (column.name === "id") made.id = freeId(rows, begins);
    else if (column.kind === "choice") made[column.name] = firstFree(column.from?.(data) ?? [], rows, column.name);
    else made[column.name] = column.kind === "rows" ? [] : null;
  }
  return [...rows, made];
}

/** What stands together in a field, as the size of a vehicle: nothing where all of it is empty, else with what is open in it. */
export function together(columns: readonly Column[], row: Row): Row | undefined {
  const empty = columns.every(({ name }) => row[name] === undefined || row[name] === null || (Array.isArray(row[name]) && row[name].length === 0));
  return empty ? undefined : row;
}

/** What a row of a list is called: by all that tells it from others. */
export function calledOf(columns: readonly Column[], row: Row): string {
  const isPair = columns[0] !== undefined && (PAIRED.has(columns[0].kind) || columns[0].name === "start");
  return columns.slice(0, isPair ? 2 : 1).map(({ name }) => writtenOf(row[name])).join(" – ");
}

/** Of which two tell a row from others. */
const PAIRED: ReadonlySet<Column["kind"]> = new Set(["time", "number"]);

function firstFree(all: readonly string[], rows: readonly Row[], name: string): string | null {
  const taken = new Set(rows.map((row) => row[name]));
  return all.find((each) => !taken.has(each)) ?? all[0] ?? null;
}

function freeId(rows: readonly Row[], begins: string): string {
  const taken = new Set(rows.map((row) => row.id));
  for (let number = 1; ; number += 1) if (!taken.has(`${begins}${number}`)) return `${begins}${number}`;
}

/** What the ids of a section begin with. */
export const BEGINS: Readonly<Record<string, string>> = { materials: "material", products: "product", stations: "station", vehicle_types: "type", fleet: "ATV" };
