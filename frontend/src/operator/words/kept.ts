/** Words as a browser keeps them. Pure. */
import type { Word } from "./words";

/** What an older page has kept: it knew machines alone. */
type Older = Omit<Word, "place" | "station"> & { readonly machine: string };

/** Null where it is not what a page has kept. */
export function wordsIn(written: string): readonly Word[] | null {
  try {
    const words: unknown = JSON.parse(written);
    return Array.isArray(words) ? (words as (Older | Word)[]).map(asNow) : null;
  } catch {
    return null;
  }
}

function asNow(word: Older | Word): Word {
  if ("place" in word) return word;
  const { machine, ...same } = word;
  return { ...same, place: machine, station: false };
}
