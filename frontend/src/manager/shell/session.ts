/** Who works at this panel, and the way out. */
import { signal } from "@preact/signals";
import { fetchMe, logOut } from "../../api/client";
import { onLoggedOut, toLogin } from "../../api/session";
import type { MeAnswer } from "../../api/types";
import { problemText } from "../problem-text";

export const me = signal<MeAnswer | null>(null);
/** Why nobody was logged out. */
export const failed = signal("");

export async function learnWho(): Promise<void> {
  // Without an answer the panel works all the same; without a session it is left for the login.
  me.value = await fetchMe().catch(() => null);
}

export async function leave(): Promise<void> {
  // The stream may end before the answer is here: leaving for the login then would cut the answer off.
  onLoggedOut(() => undefined);
  try {
    await logOut();
    location.assign("/login");
  } catch (error) {
    onLoggedOut(toLogin);
    failed.value = problemText(error);
  }
}
