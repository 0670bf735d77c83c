/** Where a finding is: the plant file's path to it in the words of the forms, and as the steps that lead to its field. Pure. */
import { type Chosen, chosenOf, type Data, entries, LISTS, SECTIONS } from "./model";

export interface Where {
  /** What is chosen on the floor for it; null for an entry of a list, and for the plant as a whole. */
  readonly chosen: Chosen | null;
  /** The entry of a list that has no place on the floor. */
  readonly listed: { readonly section: (typeof LISTS)[number]; readonly index: number } | null;
  /** The list that it is about as a whole; null where it is about an entry, or about no list. */
  readonly whole: (typeof SECTIONS)[number] | null;
  /** From there to the field. */
  readonly steps: readonly string[];
}

/** @param field as the checks name it: `machines[3].makes[0].product` */
export function whereOf(field: string): Where {
  const [section = "", ...rest] = field.split(/[.[\]]+/).filter(Boolean);
  const chosen = chosenOf(field);
  const list = LISTS.find((each) => each === section);
  const listed = list && rest[0] !== undefined ? { section: list, index: Number(rest[0]) } : null;
  const whole = rest.length === 0 ? (SECTIONS.find((each) => each === section) ?? null) : null;
  return { chosen, listed, whole, steps: chosen ?? listed ? rest.slice(1) : [section, ...rest] };
}

type Words = (group: "section" | "field" | "column", name: string) => string;

/** Where a finding is, as people read it: `Machine M3 · Makes 1 · Product`. */
export function whereText(field: string, data: Data, word: Words): string {
  const { chosen, listed, steps } = whereOf(field);
  const at = chosen ?? listed;
  const thing = at === null ? [] : chosen ? [`${word("section", at.section)} ${nameOf(entryOf(data, at))}`] : [word("section", at.section), nameOf(entryOf(data, at))];
  return [...thing, ...labelsOf(steps, chosen !== null, word)].join(" · ");
}

/** Where a finding is in the form of a thing that is drawn: `Makes 1 · Product`. */
export function fieldText(field: string, word: Words): string {
  const { chosen, steps } = whereOf(field);
  return labelsOf(steps, chosen !== null, word).join(" · ");
}

function entryOf(data: Data, { index, section }: { readonly index: number; readonly section: string }): object | null {
  return entries<object | null>(data, section)[index] ?? null;
}

/** What a thing is called in its forms. */
export function nameOf(entry: object | null): string {
  const { id, start, end } = (entry ?? {}) as { id?: string; start?: string; end?: string };
  return id ?? (start === undefined ? "?" : `${start} – ${end ?? ""}`);
}

/** Labels of the fields on the way; a row of a list has its number. */
function labelsOf(steps: readonly string[], isDrawn: boolean, word: Words): string[] {
  const labels: string[] = [];
  for (const [at, step] of steps.entries()) {
    const last = labels.length - 1;
    if (!/^\d+$/.test(step)) labels.push(labelOf(step, isDrawn && at === 0 ? ["field", "column"] : ["column", "field"], word));
    else if (last >= 0) labels[last] = `${labels[last] ?? ""} ${Number(step) + 1}`;
  }
  return labels;
}

/** The first of these groups that has words for it. */
function labelOf(name: string, groups: readonly ("field" | "column")[], word: Words): string {
  const plain = name.replaceAll("_", " ");
  return groups.map((group) => word(group, name)).find((label) => label !== plain) ?? plain;
}
