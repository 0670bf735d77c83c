/** What was odd in a file that was read, in the reader's language. */
import { n } from "../../editor";
import { findingText } from "./finding-text";

interface Note {
  readonly text: string;
  readonly place?: string;
  readonly count?: number;
  readonly code?: string;
  readonly values?: Readonly<Record<string, unknown>>;
}

/** Its place, what it is, and how often it was found; the gateway's English line where it has no code. */
export function noteText({ text, place = "", count = 1, code = "", values = {} }: Note): string {
  if (code === "") return text;
  const told = findingText({ code, values, text });
  if (told === text) return text;
  return `${place === "" ? "" : `${place}: `}${told}${count > 1 ? n("notes.times", count) : ""}`;
}
