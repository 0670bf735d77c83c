/** What a line of the audit log tells beyond its columns, in people's words: no name of a field, and no enumeration, as the gateway writes it. */
import { format, t, word } from "../../../text/views/records";

type Detail = Readonly<Record<string, unknown>>;

/** Whose values are chosen from a few that have words. */
const CHOSEN: ReadonlySet<string> = new Set(["kind", "state", "answer", "by", "priority", "session_over", "role", "scopes", "missed"]);

/** @returns nothing of what was left empty */
export function detailText(detail: Detail): string {
  return partsText(Object.entries(detail).filter(([, value]) => tellsSomething(value)));
}

/** As the gateway numbers commands: it tells people nothing. */
const NUMBERED = /^[0-9a-f]{8}-?(?:[0-9a-f]{4}-?){3}[0-9a-f]{12}$/;

/** Not what was left empty, or not asked for, nor a number that nobody has given. */
function tellsSomething(value: unknown): boolean {
  if (value === null || value === "" || value === false) return false;
  if (typeof value === "string") return !NUMBERED.test(value);
  return !(Array.isArray(value) && value.length === 0);
}

function partsText(parts: readonly (readonly [string, unknown])[]): string {
  const names = new Set(parts.map(([name]) => name));
  return parts
    // Without a vehicle there is none that alone may do it.
    .filter(([name]) => name !== "vehicle_only" || names.has("vehicle"))
    // What is so is told by its name alone.
    .map(([name, value]) => (value === true ? word("audit.of", name) : `${word("audit.of", name)} ${valueText(name, value)}`))
    .join(" · ");
}

function valueText(name: string, value: unknown): string {
  if (value === null) return t("audit.nothing");
  if (typeof value === "boolean") return t(value ? "audit.yes" : "audit.no");
  if (typeof value === "number") return numberText(name, value);
  if (Array.isArray(value)) return value.map((each) => valueText(name, each)).join(", ");
  if (typeof value === "object") return `(${partsText(Object.entries(value))})`;
  const said = typeof value === "string" ? value : JSON.stringify(value);
  if (name === "change") return changeText(said);
  return CHOSEN.has(name) ? chosenText(said) : said;
}

/** A kind may also be that of a simulated fault, which has its words elsewhere. */
function chosenText(said: string): string {
  const text = word("audit.value", said);
  return text === said.replaceAll("_", " ") ? word("fault.now", said) : text;
}

/** By its unit, which stands last in its name. */
function numberText(name: string, value: number): string {
  if (name.endsWith("_frac")) return format.percent(value);
  if (name.endsWith("_mps")) return `${format.number(value, 1)} m/s`;
  if (name.endsWith("_m")) return `${format.number(value, 1)} m`;
  return name.endsWith("_s") ? format.duration(value) : format.count(value);
}

/** A change of an order is kept as it was asked for. */
function changeText(said: string): string {
  try {
    return valueText("", JSON.parse(said));
  } catch {
    return said;
  }
}
