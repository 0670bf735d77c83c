/**
 * The life of a command, as a person follows it: sent, accepted by the plant, confirmed by the vehicle. What is
 * shown is what was heard: nothing counts as sent or accepted because it should have been. Pure; the table says
 * all there is.
 */
import type { CommandView } from "../../api/types";
import type { VehicleKind } from "../../commands/hindrance";

export type Stage =
  /** On its way to the plant. */
  | "sent"
  /** It has not left this tablet, as far as that can be known here. */
  | "not_sent"
  /** The plant has passed it on to the vehicle. */
  | "accepted"
  /** The vehicle has done it. */
  | "confirmed"
  /** The vehicle, or the plant, has said no. */
  | "refused"
  /** Nobody has said anything in time: it may or may not have been heard. */
  | "not_confirmed";

export type Word =
  /** The plant has passed it on. */
  | "passed_on"
  /** The vehicle has done it, or has said no. */
  | "done"
  | "declined"
  /** The plant was heard, and the vehicle was not. */
  | "silence"
  /** The plant has said no, and passed nothing on. */
  | "rejected"
  /** Not even the plant was heard: it may or may not have come through. */
  | "unanswered"
  /** There was no way to the plant. */
  | "unsent";

/** What a word leads to. A word that has no entry changes nothing: it is late, or said twice. */
const NEXT: Readonly<Record<Stage, Readonly<Partial<Record<Word, Stage>>>>> = {
  sent: {
    passed_on: "accepted", done: "confirmed", declined: "refused", rejected: "refused",
    silence: "not_confirmed", unanswered: "not_confirmed", unsent: "not_sent",
  },
  // The plant tells it in the stream, too: a lost answer proves nothing then.
  accepted: { done: "confirmed", declined: "refused", silence: "not_confirmed", unanswered: "not_confirmed", unsent: "not_confirmed" },
  not_sent: { passed_on: "accepted", done: "confirmed", declined: "refused", silence: "not_confirmed" },
  // A late word is still the vehicle's.
  not_confirmed: { done: "confirmed", declined: "refused" },
  confirmed: {},
  refused: {},
};

/** Words that only come when the plant has passed it on. */
const AFTER_PASSING: ReadonlySet<Word> = new Set(["passed_on", "done", "declined", "silence"]);

export interface Command {
  readonly id: string;
  /** To whom: a vehicle or a machine. */
  readonly atv: string;
  readonly kind: Kind;
  /** Of `set_speed`. */
  readonly speedFrac: number | null;
  readonly by: string;
  readonly stage: Stage;
  /** Whether the plant has passed it on to the vehicle. */
  readonly accepted: boolean;
  /** Why it was refused, or why nobody knows; empty otherwise. */
  /** Why the vehicle has refused it: one of the reasons of the wire. Empty where it has not. */
  readonly reason: string;
  /** What stood in its way, in words. */
  readonly detail: string;
  /** When the stage was reached, on the server's clock. */
  readonly atS: number;
}

export type Kind = VehicleKind | "clear_fault" | "restart" | "update" | "fetch_goods" | "write_off" | "load_there" | "load_missing" | WordKind;

/** What people say has happened at a machine whose body they are. */
export type WordKind = "arrived" | "taken" | "made" | "scrapped" | "stock_is";

/** The command after a word about it; the same one where the word is no news. */
/** What somebody has said of why not. */
export interface Why {
  readonly reason: string | null;
  readonly detail: string;
}

export function afterWord(command: Command, word: Word, atS: number, why: Why = { reason: null, detail: "" }): Command {
  const stage = NEXT[command.stage][word];
  const accepted = command.accepted || AFTER_PASSING.has(word);
  if (stage === undefined) return accepted === command.accepted ? command : { ...command, accepted };
  return { ...command, stage, accepted, reason: why.reason ?? "", detail: why.detail, atS };
}

const WORDS = { sent: "passed_on", confirmed: "done", refused: "declined", not_confirmed: "silence" } as const;

/**
 * What the plant tells of a command, together with what is known of it here.
 *
 * @param own as this page knows it; undefined where another page gave it
 */
export function fromPlant(view: CommandView, own: Command | undefined): Command {
  const { atv, by, id, kind, speed_frac: speedFrac, at_s: sentS, state } = view;
  const given = own ?? { id, atv, kind, speedFrac, by, stage: "sent", accepted: false, reason: "", detail: "", atS: sentS };
  return afterWord(given, WORDS[state], given.atS, view);
}

/** Whether somebody still waits for a word on it. */
export function isUnderway({ stage }: Pick<Command, "stage">): boolean {
  return stage === "sent" || stage === "accepted";
}

/** The stages as they are shown in a row, those that were passed and the one that it has come to. */
export function stagesOf({ accepted, stage }: Pick<Command, "stage" | "accepted">): readonly Stage[] {
  if (stage === "sent" || stage === "not_sent") return [stage];
  return accepted && stage !== "accepted" ? ["sent", "accepted", stage] : ["sent", stage];
}
