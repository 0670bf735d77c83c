import { batch, type ReadonlySignal, type Signal, untracked, useComputed, useSignal, useSignalEffect } from "@preact/signals";
import { useRef } from "preact/hooks";
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
  const question = useComputed(ask);
  const questionBefore = useRef<Promise<T> | null>(null);
  useSignalEffect(() => refreshing(ask, everyMs, { answer, failed, question, questionBefore, turn }));
  return { answer, failed, again: () => (turn.value = turn.peek() + 1) };
}

interface Told<T> extends Pick<Refreshed<T>, "answer" | "failed"> {
  /** The first answer to a question: another promise for another question, whenever a signal changes that `ask` reads. */
  readonly question: ReadonlySignal<Promise<T>>;
  readonly questionBefore: { current: Promise<T> | null };
  /** Counts how often somebody asked at once. */
  readonly turn: Signal<number>;
}

/** Asks, as an effect: again after a while, at the next turn, and anew when the question is another one. Returns what ends it. */
export function refreshing<T>(ask: () => Promise<T>, everyMs: number, { answer, failed, question, questionBefore, turn }: Told<T>): () => void {
  let timer: ReturnType<typeof setTimeout> | undefined;
  const mine = turn.value;
  let shown = true;
  /** Another question may be asked by the time that this one is answered. */
  const isAsked = (): boolean => shown && mine === turn.peek();
  const refresh = async (coming: Promise<T>): Promise<void> => {
    try {
      const found = await coming;
      if (isAsked()) batch(() => ([answer.value, failed.value] = [found, null]));
    } catch (error) {
      if (isAsked()) failed.value = problemText(error);
    }
    if (shown) timer = setTimeout(() => void refresh(ask()), everyMs);
  };
  const first = question.value;
  const isAnother = first !== questionBefore.current;
  questionBefore.current = first;
  // Why another question had no answer says nothing of this one; of the same one, asked at once, it does.
  if (isAnother) failed.value = null;
  void refresh(isAnother ? first : untracked(ask));
  return () => {
    shown = false;
    clearTimeout(timer);
  };
}
