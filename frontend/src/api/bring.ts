/** Soon after a network is back, and no burden while it is away. */
const AGAIN_MS = 3_000;

/**
 * Loads a script that is needed only now, and shows it. What the network does not bring is asked for again: at once when the browser says
 * that it is back, else every few seconds, since not every cut is one that a browser knows of. `failed` is told of each try that fails.
 *
 * @returns what ends it
 */
export function bring<T>(load: () => Promise<T>, show: (loaded: T) => void, failed: () => void = () => undefined): () => void {
  let timer: ReturnType<typeof setTimeout> | undefined;
  let wanted = true;
  const stop = (): void => {
    wanted = false;
    clearTimeout(timer);
    removeEventListener("online", retry);
  };
  const attempt = async (): Promise<void> => {
    try {
      const loaded = await load();
      if (!wanted) return;
      stop();
      show(loaded);
    } catch {
      if (!wanted) return;
      failed();
      timer = setTimeout(retry, AGAIN_MS);
    }
  };
  function retry(): void {
    if (timer === undefined) return; // A try is on its way.
    clearTimeout(timer);
    timer = undefined;
    void attempt();
  }
  addEventListener("online", retry);
  void attempt();
  return stop;
}
