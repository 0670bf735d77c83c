/**
 * Who stands before the panel. Whatever ends the session, the panel stays as it is and says why: nobody is sent
 * to a login from the middle of work. After its time, or when its person has logged in elsewhere, stop goes on to
 * work for a while (the server sees to that). One that was taken back is worth nothing any more, and the panel
 * says that, too.
 */
import { signal } from "@preact/signals";
import { fetchMe, logOut } from "../../api/client";
import { Problem } from "../../api/problem";
import { onLoggedOut, toLogin } from "../../api/session";
import type { MeAnswer } from "../../api/types";

/** The gateway may come up after the page. */
const RETRY_MS = 3000;

export const me = signal<MeAnswer | null>(null);
/** Why a session is over; the server's kinds of a problem. */
const ENDINGS = { "session-run-out": "run_out", "session-replaced": "replaced" } as const;

export type Ending = (typeof ENDINGS)[keyof typeof ENDINGS] | "taken_back";

/** Null as long as it goes on. */
export const ended = signal<Ending | null>(null);

let asking = false;
/** The stream has ended while an answer was on its way, which may still tell of the session before. */
let overtaken = false;
/** The stream may end before the answer to the logout is here, which is no news then. */
let leaving = false;

export function beginSession(): void {
  onLoggedOut(() => {
    if (ended.value === null && !leaving) void lookAgain();
  });
  // Somebody may have logged in again in another tab.
  document.addEventListener("visibilitychange", () => {
    if (ended.value !== null && document.visibilityState === "visible") void lookAgain();
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
  if (asking) overtaken = true;
  else if (await learnWho()) location.reload();
}

/** @returns whether somebody is logged in */
async function learnWho(): Promise<boolean> {
  asking = true;
  try {
    me.value = await fetchMe();
    return true;
  } catch (error) {
    if (!(error instanceof Problem)) throw error;
    if (error.kind in ENDINGS) ended.value = ENDINGS[error.kind as keyof typeof ENDINGS];
    else if (error.status !== 401) setTimeout(() => !asking && void learnWho(), RETRY_MS);
    else if (me.value === null) toLogin();
    else ended.value = "taken_back";
    return false;
  } finally {
    asking = false;
    // Asking may itself have brought the news that the session has ended: then `ended` says why.
    if (overtaken && ended.value === null) void lookAgain();
    overtaken = false;
  }
}
