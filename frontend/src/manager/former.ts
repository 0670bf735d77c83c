/** Names of products that were removed: orders that have ended still name them. Asked for when one is met. */
import { signal } from "@preact/signals";

/** After an answer that failed. Until then nothing is asked, however often names are wanted. */
export const PAUSE_MS = 10_000;

const known = signal<ReadonlyMap<string, string>>(new Map());
/** Counts pauses that have ended: whoever has wanted a name meanwhile draws again, and so wants it again. */
const pauses = signal(0);
/** Of these it is known that they have a name, or none. */
const answered = new Set<string>();
const wanted = new Set<string>();
/** While an answer is waited for, and in the pause after one that failed. */
let isBusy = false;

export function formerName(id: string): string {
  const name = known.value.get(id);
  if (name === undefined && !answered.has(id)) {
    pauses.value.valueOf();
    wanted.add(id);
    // Not while something is drawn.
    if (!isBusy) queueMicrotask(() => void ask());
  }
  return name ?? id;
}

async function ask(): Promise<void> {
  if (isBusy || wanted.size === 0) return;
  isBusy = true;
  const ids = [...wanted];
  wanted.clear();
  try {
    const { fetchDefinitions } = await import("../api/products");
    const found = await fetchDefinitions(true);
    for (const id of ids) answered.add(id);
    known.value = new Map(found.map(({ id, name }) => [id, name]));
    isBusy = false;
    // Wanted while it was asked.
    void ask();
  } catch {
    // Ids are shown, as they are of whatever nobody knows.
    setTimeout(() => {
      isBusy = false;
      wanted.clear();
      pauses.value++;
    }, PAUSE_MS);
  }
}
