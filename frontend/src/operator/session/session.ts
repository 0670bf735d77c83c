/**
 * Who stands before the panel. A session that ends by time leaves the panel as it is: stop goes on to
 * work for a while (the server sees to that), and a person logs in again when there is time for it.
 */
import { signal } from "@preact/signals";
import { fetchMe, type Me, Problem } from "../../api/client";

export const me = signal<Me | null>(null);
export const ended = signal(false);

export async function learnWho(): Promise<void> {
  try {
    me.value = await fetchMe();
    ended.value = false;
  } catch (error) {
    if (error instanceof Problem && error.status === 401) endSession();
  }
}

export function endSession(): void {
  ended.value = true;
}
