/** Lists that come in pages. */

interface Page<T> {
  readonly items: readonly T[];
  readonly next_cursor: string | null;
}

/** Items of one page: few requests, and none that takes long. */
const LIMIT = 200;

/** All of a list, page after page. */
export async function allOf<T>(ask: (query: { limit: number; cursor?: string }) => Promise<Page<T>>): Promise<T[]> {
  const found: T[] = [];
  let cursor: string | null = null;
  do {
    const page: Page<T> = await ask(cursor === null ? { limit: LIMIT } : { limit: LIMIT, cursor });
    found.push(...page.items);
    cursor = page.next_cursor;
  } while (cursor !== null);
  return found;
}
