/** Lists of the plant file that are filled in as forms: which columns an entry has, and of what each is chosen. Pure. */
import { type Data, entries, nodesOf } from "./model";

export type Row = Readonly<Record<string, unknown>>;

export interface Column {
  readonly name: string;
  readonly kind: "text" | "count" | "number" | "words" | "choice" | "rows";
  /** What an entry does without: left empty it is not in the file. */
  readonly optional?: true;
  /** Of a choice: what can be chosen. */
  readonly from?: (data: Data) => readonly string[];
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
const optional = (column: Column): Column => ({ ...column, optional: true });

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
  fleet: [text("id"), choice("type", (data) => ids(data, "vehicle_types")), choice("node", (data) => nodesOf(data).map(({ id }) => id)), optional(number("battery_frac"))],
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

/** What a column says that somebody has filled in; undefined for nothing. A number that is none stays as it was written, for the checks. */
export function valueOf(column: Column, written: string): unknown {
  const said = written.trim();
  if (said === "") return undefined;
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
    if (column.optional) continue;
    if (column.name === "id") made.id = freeId(rows, begins);
    else if (column.kind === "choice") made[column.name] = firstFree(column.from?.(data) ?? [], rows, column.name);
    else made[column.name] = column.kind === "rows" ? [] : null;
  }
  return [...rows, made];
}

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
