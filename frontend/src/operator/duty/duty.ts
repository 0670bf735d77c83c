/**
 * Whether this person is on duty. The panel asks for it every few seconds while that is so: by that the gateway knows that somebody
 * is there. A gateway that was started again has forgotten it, and is told anew.
 */
import { signal } from "@preact/signals";
import { answerCall, fetchDuty, putDuty } from "../../api/client";
import { Problem } from "../../api/problem";
import type { CallAnswerRequest, CallView, DutyRequest, DutyView } from "../../api/types";
import { ended, me } from "../session/session";

export type DutyState = DutyView["state"];

/** Well below the 20 seconds that somebody has to answer. */
const ASK_MS = 3000;

const KEPT = "dray-duty";

export const duty = signal<DutyView | null>(null);
/** What could not be done, in the server's words; empty for nothing. */
export const dutyFailed = signal("");

let timer = 0;

/** Views that were asked for, and up to which of them a newer one is shown: what comes late is dropped. */
let asked = 0;
let shown = 0;

/** What this person has chosen here; another one who logs in in this tab has chosen nothing yet. */
function wanted(): DutyState {
  const [person, state] = (sessionStorage.getItem(KEPT) ?? "").split(" ");
  return person === me.value?.id && (state === "on" || state === "break") ? state : "off";
}

/** Begins when it is known whose duty it is: a choice is kept under that person. */
export function beginDuty(): void {
  me.subscribe((person) => {
    if (person !== null) void ask();
  });
}

/** Goes on duty, has a break, or goes off duty. */
export async function be(state: DutyState, more: Omit<DutyRequest, "state"> = {}): Promise<void> {
  sessionStorage.setItem(KEPT, `${me.value?.id ?? ""} ${state}`);
  await tell(() => putDuty({ state, ...more }), true);
}

/** Answers a call for help. */
export async function answer(call: CallView, said: CallAnswerRequest): Promise<void> {
  await tell(async () => {
    await answerCall(call.id, said);
    return await fetchDuty();
  }, true);
}

async function ask(): Promise<void> {
  if (ended.value !== null || (wanted() === "off" && duty.value !== null)) return;
  try {
    await tell(async () => {
      const view = await fetchDuty();
      const state = wanted();
      return view.state === "off" && state !== "off" ? await putDuty({ state }) : view;
    });
  } finally {
    again();
  }
}

function again(): void {
  clearTimeout(timer);
  timer = window.setTimeout(() => void ask(), ASK_MS);
}

/** Shows a view. What was asked for before a person's act was done may tell how it was before, so the act counts as asked last. */
async function tell(what: () => Promise<DutyView>, isAct = false): Promise<void> {
  try {
    const before = duty.value;
    const begun = ++asked;
    const view = await what();
    const mine = isAct ? ++asked : begun;
    if (mine < shown) return;
    shown = mine;
    duty.value = view;
    dutyFailed.value = "";
    if (isAsked(duty.value) && !isAsked(before) && "vibrate" in navigator) navigator.vibrate([200, 100, 200]);
    again();
  } catch (error) {
    if (!(error instanceof Problem)) throw error;
    dutyFailed.value = error.message;
  }
}

function isAsked(view: DutyView | null): boolean {
  return view?.calls.some(({ part }) => part === "asked") ?? false;
}
