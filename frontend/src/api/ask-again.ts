/**
 * Asks at once and again and again, and shows each answer, until the function that is returned is called. What cannot be answered is asked
 * again: the stream, or the view itself, tells that nothing can be read.
 */
export function askAgain<T>(fetch: () => Promise<T>, show: (found: T) => void, everyMs: number): () => void {
  let shown = true;
  const ask = async (): Promise<void> => {
    try {
      const found = await fetch();
      if (shown) show(found);
    } catch {
      // It is asked again.
    }
  };
  void ask();
  const timer = setInterval(() => void ask(), everyMs);
  return () => {
    shown = false;
    clearInterval(timer);
  };
}
