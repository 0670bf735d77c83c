/** All that a list finds, page by page, up to a bound. Pure but for what it is given. */
import type { PageOf } from "../pages/paged";

/** Some 150 sheets: more is for a spreadsheet. */
export const ROWS_MOST = 5000;

/**
 * @param fetchAfter asks for the page behind a cursor; empty for the first one
 * @param onRead is told how many have come
 */
export async function readWhole<T>(fetchAfter: (after: string) => Promise<PageOf<T>>, onRead: (rows: number) => void, most = ROWS_MOST): Promise<PageOf<T>> {
  const items: T[] = [];
  let after: string | null = "";
  while (after !== null && items.length < most) {
    const page: PageOf<T> = await fetchAfter(after);
    items.push(...page.items);
    onRead(items.length);
    after = page.next_cursor;
  }
  return { items: items.slice(0, most), next_cursor: items.length > most ? (after ?? "more") : after };
}
