import { batch, effect, type Signal, untracked, useSignal, useSignalEffect } from "@preact/signals";
import { useLayoutEffect, useRef } from "preact/hooks";
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
  const asking = useRef(ask);
  // The effect runs once for many renders: each of them may ask about something else.
  useLayoutEffect(() => {
    asking.current = ask;
  });
  useSignalEffect(() => refreshing(asking, everyMs, { answer, failed, turn }));
  return { answer, failed, again: () => (turn.value = turn.peek() + 1) };
}

interface Told<T> extends Pick<Refreshed<T>, "answer" | "failed"> {
  /** Counts how often somebody asked at once. */
  readonly turn: Signal<number>;
}

/**
 * Asks one question, as an effect that runs anew when a signal changes that `ask` reads: at once, again after a while, and at every turn. Returns what ends it.
 *
 * @param ask the question as it is put now: read each time that it is asked
 */
export function refreshing<T>(ask: { readonly current: () => Promise<T> }, everyMs: number, { answer, failed, turn }: Told<T>): () => void {
  let timer: ReturnType<typeof setTimeout> | undefined;
  let shown = true;
  let asked = 0;
  const refresh = async (): Promise<void> => {
    clearTimeout(timer);
    const mine = ++asked;
    /** Another question may be asked by the time that this one is answered. */
    const isAsked = (): boolean => shown && mine === asked;
    try {
      const found = await ask.current();
      if (isAsked()) batch(() => ([answer.value, failed.value] = [found, null]));
    } catch (error) {
      if (isAsked()) failed.value = problemText(error);
    }
    if (isAsked()) timer = setTimeout(() => void refresh(), everyMs);
  };
  // Why another question had no answer says nothing of this one; of the same one, asked at once, it does.
  failed.value = null;
  void refresh();
  let turnBefore = turn.peek();
  const leaveTurns = effect(() => {
    if (turn.value === turnBefore) return;
    turnBefore = turn.value;
    untracked(() => void refresh());
  });
  return () => {
    shown = false;
    leaveTurns();
    clearTimeout(timer);
  };
}
