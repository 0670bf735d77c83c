/** Names of products that were removed: orders that have ended still name them. Asked for when one is met. */
import { signal } from "@preact/signals";

const known = signal<ReadonlyMap<string, string>>(new Map());
const asked = new Set<string>();
let asking = false;

export function formerName(id: string): string {
  const name = known.value.get(id);
  if (name === undefined && !asked.has(id)) {
    asked.add(id);
    // Not while something is drawn.
    queueMicrotask(() => void ask());
  }
  return name ?? id;
}

async function ask(): Promise<void> {
  if (asking) return;
  asking = true;
  try {
    const { fetchDefinitions } = await import("../api/products");
    known.value = new Map((await fetchDefinitions(true)).map(({ id, name }) => [id, name]));
  } catch {
    // Its id is shown, as it is of whatever nobody knows.
  } finally {
    asking = false;
  }
}
