/** How a chart is read by keyboard. Pure. */

/** Where a key moves the pointer; undefined for keys that do not. */
export function stepFor(key: string, at: number | null, count: number): number | null | undefined {
  const last = count - 1;
  switch (key) {
    case "ArrowLeft":
      return at === null ? last : Math.max(0, at - 1);
    case "ArrowRight":
      return at === null ? last : Math.min(last, at + 1);
    case "Home":
      return 0;
    case "End":
      return last;
    case "Escape":
      return null;
    default:
      return undefined;
  }
}
