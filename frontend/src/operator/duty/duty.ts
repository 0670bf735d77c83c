/**
 * Whether this person is on duty. The panel asks for it every few seconds as long as somebody can see it: by that the gateway knows that
 * somebody is there. A gateway that was started again has forgotten it, and is told anew; what was chosen in another tab counts in this one.
 */
import { computed, type Signal, signal } from "@preact/signals";
import { beginSound, playSound } from "../../alerts/sound";
import { answerCall, fetchDuty, putDuty } from "../../api/client";
import { Problem } from "../../api/problem";
import type { CallAnswerRequest, CallView, DutyRequest, DutyView } from "../../api/types";
import { problemText } from "../problem-text";
import { ended, me } from "../session/session";
import { vibrate } from "./vibrate";

export type DutyState = DutyView["state"];

/** Well below the 20 seconds that somebody has to answer. */
const ASK_MS = 3000;

/** A line is read in less. */
const READ_MS = 15_000;

const KEPT = "dray-duty";

export const duty = signal<DutyView | null>(null);
/** What could not be done, in the server's words; empty for nothing. */
export const dutyFailed = signal("");
/** Why the last answer to a call has not come there; empty for nothing to say. */
export const callFailed = signal("");
/** The call that this person wanted to take too late, and who comes; empty where nobody knows. */
export const missed = signal<{ readonly caller: string; readonly by: string } | null>(null);

let timer = 0;

/** Views that were asked for, and up to which of them a newer one is shown: what comes late is dropped. */
let asked = 0;
let shown = 0;

type Choice = Pick<DutyView, "state" | "helps_with">;

/** What this person has chosen; another one who logs in in this tab has chosen nothing yet. */
function wanted(): Choice {
  const [person, state, ...kinds] = (sessionStorage.getItem(KEPT) ?? "").split(" ");
  if (person !== me.value?.id || (state !== "on" && state !== "break")) return { state: "off", helps_with: [] };
  return { state, helps_with: kinds as Choice["helps_with"] };
}

function keep({ helps_with: kinds, state }: Choice): void {
  sessionStorage.setItem(KEPT, [me.value?.id ?? "", state, ...kinds].join(" "));
}

/** Begins when it is known whose duty it is: a choice is kept under that person. */
export function beginDuty(): void {
  beginSound();
  me.subscribe((person) => {
    if (person !== null) void ask();
  });
  document.addEventListener("visibilitychange", () => {
    if (me.value !== null) void ask();
  });
}

/** Goes on duty, has a break, or goes off duty; what for stays as it is, if nothing else is said. */
export async function be(state: DutyState, more: Omit<DutyRequest, "state"> = {}): Promise<void> {
  const choice = { state, helps_with: duty.value?.helps_with ?? [], ...more };
  keep(choice);
  await tell(() => putDuty(choice), dutyFailed);
}

/** Answers a call for help. */
export async function answer(call: CallView, said: CallAnswerRequest): Promise<void> {
  await tell(async () => {
    const tooLate = await isMissed(call.id, said);
    const view = await fetchDuty();
    const by = view.calls.find(({ id }) => id === call.id)?.taken_by ?? "";
    missed.value = tooLate ? { caller: call.caller, by } : null;
    if (tooLate) window.setTimeout(() => { missed.value = null; }, READ_MS);
    return view;
  }, callFailed);
}

/** Whether who wants to take a call comes too late. */
async function isMissed(call: string, said: CallAnswerRequest): Promise<boolean> {
  try {
    return !(await answerCall(call, said)) && said.answer === "take";
  } catch (error) {
    if (error instanceof Problem && error.kind === "call-over") return true;
    throw error;
  }
}

/** Whether a call of a vehicle or a machine has a card with answers of its own. */
export function hasCallCard(caller: string): boolean {
  const part = callOf(caller)?.part ?? null;
  return part !== null;
}

/** The call of a vehicle or a machine that this person may take now, or has taken; undefined where that is no call of somebody on duty. */
export function callOf(caller: string): CallView | undefined {
  const view = duty.value;
  if (view?.state !== "on") return undefined;
  return view.calls.find((call) => call.caller === caller && call.goods === "" && (call.taken_by === "" || call.taken_by === view.code));
}

async function ask(): Promise<void> {
  if (ended.value !== null) return;
  try {
    // Whoever cannot see the page sees no call either.
    if (document.visibilityState === "visible") await tell(lookAgain);
  } finally {
    again();
  }
}

async function lookAgain(): Promise<DutyView> {
  const view = await fetchDuty();
  const choice = wanted();
  if (view.state === "off" && !view.said_off && choice.state !== "off") return await putDuty(choice);
  keep(view);
  return view;
}

function again(): void {
  clearTimeout(timer);
  timer = window.setTimeout(() => void ask(), ASK_MS);
}

/** Shows a view. What was asked for before a person's act was done may tell how it was before, so the act counts as asked last. */
async function tell(what: () => Promise<DutyView>, act?: Signal<string>): Promise<void> {
  const failed = act ?? dutyFailed;
  try {
    const before = duty.value;
    const begun = ++asked;
    const view = await what();
    const mine = act ? ++asked : begun;
    failed.value = "";
    if (mine < shown) return;
    shown = mine;
    duty.value = view;
    if (askingCaller.value !== "") {
      if (!isAsked(before)) vibrate();
      // Each time that is asked for again, until there is an answer.
      playSound();
    }
    again();
  } catch (error) {
    if (!(error instanceof Problem)) throw error;
    failed.value = problemText(error);
  }
}

/** Who calls this person and waits for an answer; empty for nobody. */
export const askingCaller = computed(() => duty.value?.calls.find(({ part }) => part === "asked")?.caller ?? "");

function isAsked(view: DutyView | null): boolean {
  return view?.calls.some(({ part }) => part === "asked") ?? false;
}
