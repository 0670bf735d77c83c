import { type Signal, useSignal, useSignalEffect } from "@preact/signals";
import { problemText } from "./problem-text";

export interface Refreshed<T> {
  readonly answer: Signal<T | null>;
  /** Why the last question had no answer; the answer before it stays. */
  readonly failed: Signal<string | null>;
  /** Asks at once: something was changed. */
  readonly again: () => void;
}

/**
 * An answer that is asked for again and again while its view is shown, and at once when a signal that
 * `ask` reads has changed.
 */
export function useRefreshed<T>(ask: () => Promise<T>, everyMs: number): Refreshed<T> {
  const answer = useSignal<T | null>(null);
  const failed = useSignal<string | null>(null);
  const turn = useSignal(0);
  useSignalEffect(() => {
    let timer: ReturnType<typeof setTimeout> | undefined;
    const mine = turn.value;
    let shown = true;
    const refresh = async (): Promise<void> => {
      try {
        const found = await ask();
        if (shown && mine === turn.peek()) answer.value = found;
        failed.value = null;
      } catch (error) {
        failed.value = problemText(error);
      }
      if (shown) timer = setTimeout(() => void refresh(), everyMs);
    };
    void refresh();
    return () => {
      shown = false;
      clearTimeout(timer);
    };
  });
  return { answer, failed, again: () => turn.value++ };
}
