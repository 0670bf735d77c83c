/** Tables whose rows stand as blocks where the window is narrow (styles/parts/stacked.css). */

/** What the columns are called, for the cells below one another to say; ten at most. */
export function columnsOf(heads: readonly string[]): Record<string, string> {
  return Object.fromEntries(heads.map((head, i) => [`--head-${i + 1}`, JSON.stringify(head)]));
}
