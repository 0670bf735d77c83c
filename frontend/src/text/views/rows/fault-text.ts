/** What is wrong with a field, with a cell of a spreadsheet, or with a request as a whole, in the reader's language. */
import { fill } from "../../catalogue";
import { speakAlso } from "../../speech";
import { tables, word } from "./index";

interface Fault {
  readonly field: string;
  readonly reason: string;
  readonly code?: string;
  readonly values?: Readonly<Record<string, string>>;
}

/** Fields and columns that hold names of things in the plant. */
const IDS: ReadonlySet<string> = new Set(["id", "product", "material", "machine", "ability"]);

/** A fault of a field; the gateway's words where there are none here. */
export async function faultText({ code = "", field, reason, values = {} }: Fault): Promise<string> {
  await speakAlso(tables);
  const message = messageOf(code, field.split(".").at(-1) ?? "");
  return message === null ? reason : fill(message, values);
}

/** Why nothing came of a request; null where there are no words here for its kind of problem. */
export async function kindText(kind: string): Promise<string | null> {
  await speakAlso(tables);
  return told("problem", kind) ?? (kind.startsWith("unknown-") ? told("problem", "unknown") : null);
}

/** The message of a code, by what the field or column holds; null for none, and for a code of a newer gateway. */
export function messageOf(code: string, field: string): string | null {
  if (code === "") return null;
  if (code !== "pattern") return told("rowFault", code);
  return told("rowFault", `pattern.${IDS.has(field) ? "id" : field}`) ?? told("rowFault", "pattern");
}

function told(group: "problem" | "rowFault", code: string): string | null {
  const message = word(group, code);
  return message === code.replaceAll("_", " ") ? null : message;
}
