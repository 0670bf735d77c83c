/**
 * Who stands before the panel. A session that ends by time leaves the panel as it is: stop goes on to
 * work for a while (the server sees to that), and a person logs in again when there is time for it. One
 * that was ended on purpose is worth nothing any more: the login is all that is left.
 */
import { signal } from "@preact/signals";
import { fetchMe, logOut, type Me, Problem } from "../../api/client";
import { onLoggedOut, toLogin } from "../../api/session";

/** The gateway may come up after the page. */
const RETRY_MS = 3000;

export const me = signal<Me | null>(null);
/** It has run out of time. */
export const ended = signal(false);

let asking = false;
/** The stream may end before the answer to the logout is here, which is no news then. */
let leaving = false;

export function beginSession(): void {
  onLoggedOut(() => {
    if (!ended.value && !leaving) void lookAgain();
  });
  // Somebody may have logged in again in another tab.
  document.addEventListener("visibilitychange", () => {
    if (ended.value && document.visibilityState === "visible") void lookAgain();
  });
  void learnWho();
}

/** Logs out; where no answer comes the session stays, and so does the panel. */
export async function leave(): Promise<void> {
  leaving = true;
  await logOut().then(
    () => {
      location.assign("/login?as=operator");
    },
    () => {
      leaving = false;
    },
  );
}

/** Begins anew with whoever is logged in by now. */
async function lookAgain(): Promise<void> {
  if (await learnWho()) location.reload();
}

/** @returns whether somebody is logged in */
async function learnWho(): Promise<boolean> {
  // Asking may itself bring the news that the session has ended.
  if (asking) return false;
  asking = true;
  try {
    me.value = await fetchMe();
    return true;
  } catch (error) {
    if (!(error instanceof Problem)) throw error;
    if (error.kind === "session-run-out") ended.value = true;
    else if (error.status === 401) toLogin();
    else setTimeout(() => void learnWho(), RETRY_MS);
    return false;
  } finally {
    asking = false;
  }
}
