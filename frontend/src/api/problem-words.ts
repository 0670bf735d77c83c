/** Problems in the reader's language, wherever a panel shows them: the words come when there is a problem. */
import type { FieldError } from "./types";
import { Problem } from "./problem";

/** Values of faults that are ids of materials or products, or several of them. */
const ITEMS = ["item", "items", "product", "products"] as const;

let nameOf = (id: string): string => id;

/** What a panel calls materials and products, wherever a problem names them by their ids. */
export function nameItemsBy(names: (id: string) => string): void {
  nameOf = names;
}

/** A fault with the names of its items. */
export function named<F extends Pick<FieldError, "values">>(fault: F): F {
  const values = { ...fault.values };
  for (const key of ITEMS) if (values[key] !== undefined) values[key] = values[key].split(", ").map(nameOf).join(", ");
  return { ...fault, values };
}

/** So long the words may be under way: that something was not done has to be seen at once. */
const WORDS_MS = 1_000;

/** @returns the problem with its faults, or its kind, in words; what has none here, or not in time, stays as the gateway says it */
export async function worded(problem: Problem): Promise<Problem> {
  if (problem.kind === "" || problem.status === 401) return problem;
  const late = new Promise<Problem>((resolve) => { AbortSignal.timeout(WORDS_MS).addEventListener("abort", () => { resolve(problem); }); });
  return await Promise.race([inWords(problem).catch(() => problem), late]);
}

async function inWords(problem: Problem): Promise<Problem> {
  const { errors, kind, status } = problem;
  const { faultText, kindText } = await import("../text/views/rows/fault-text");
  if (errors.some(({ code }) => code)) {
    const faults = await Promise.all(errors.map(async (each): Promise<FieldError> => ({ ...each, reason: await faultText(named(each)) })));
    return new Problem(status, faults.map(({ reason }) => reason).join(" "), faults, kind);
  }
  const text = await kindText(kind);
  return text === null ? problem : new Problem(status, text, errors, kind);
}
