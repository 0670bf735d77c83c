/** Whether some text holds the words that somebody looks for. Pure. */
export function holds(words: string, ...texts: readonly (string | null)[]): boolean {
  const text = texts.join(" ").toLowerCase();
  return words.toLowerCase().split(/\s+/).every((word) => text.includes(word));
}
