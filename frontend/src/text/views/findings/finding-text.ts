/** A finding of the plant's checks in the reader's language. */
import { fill } from "../../catalogue";
import { format, textsOf } from "../../speech";
import type { findings } from "./en";

const { word } = textsOf<typeof findings>();

interface Told {
  readonly code?: string;
  readonly values?: Readonly<Record<string, unknown>>;
  readonly text: string;
}

/** The gateway's English where there are no words here for its code. */
export function findingText({ code = "", values = {}, text }: Told): string {
  const message = word("finding", code);
  if (code === "" || message === code.replaceAll("_", " ")) return text;
  return fill(message, Object.fromEntries(Object.entries(values).map(([name, value]) => [name, filled(name, value)])));
}

function filled(name: string, value: unknown): string {
  if (Array.isArray(value)) return value.map((each) => filled(name, each)).join(", ");
  if (typeof value === "number") return format.number(value, digitsOf(name, value));
  return typeof value === "object" && value !== null ? findingText(value as Told) : String(value);
}

/** Metres are told to the centimetre, all else to the tenth; whole numbers as they are. */
function digitsOf(name: string, value: number): number {
  if (Number.isInteger(value)) return 0;
  return name.endsWith("_m") || Math.abs(value) < 1 ? 2 : 1;
}
