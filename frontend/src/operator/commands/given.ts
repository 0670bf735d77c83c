/** The commands that were given on this page, and what has become of them. */
import { computed, signal } from "@preact/signals";
import { commandAtv, type CommandRequest, newKey, Problem } from "../../api/client";
import { serverNowS } from "../../stream/stream";
import { t } from "../../text/operator";
import { problemText } from "../problem-text";
import { me } from "../session/session";
import { type Command, hear, type Word } from "./life";

/** A card shows the last one of its vehicle: more than vehicles in an area are of no use. */
const KEPT = 100;

/** By id, the oldest first. */
const given = signal<ReadonlyMap<string, Command>>(new Map());

/** By vehicle, the last one that was given here. */
const lastGiven = computed(() => new Map([...given.value.values()].map((command) => [command.atv, command])));

/** The last command to a vehicle. */
export function lastOf(atv: string): Command | undefined {
  return lastGiven.value.get(atv);
}

/** The command that something was said about last. */
export const lastSaid = computed(() =>
  [...given.value.values()].reduce<Command | null>((last, each) => (last && last.atS > each.atS ? last : each), null),
);

/** Sends a command once, and never again: a person must know what became of it, and decide anew. */
export async function give(atv: string, request: CommandRequest): Promise<void> {
  const id = newKey();
  const { kind, speed_frac: speedFrac = null } = request;
  keep({ id, atv, kind, speedFrac, by: me.value?.name ?? "", stage: "sent", reason: "", atS: serverNowS() });
  try {
    const answer = await commandAtv(atv, request);
    tell(id, answer.done ? "done" : "declined", answer.reason);
  } catch (error) {
    tell(id, ...wordOf(error));
  }
}

function wordOf(error: unknown): [Word, string] {
  if (!(error instanceof Problem)) return ["silence", problemText(error)];
  if (error.status === 0) return ["silence", t("command.unreachable")];
  if (error.status === 504) return ["silence", t("command.silent")];
  return ["declined", problemText(error)];
}

function tell(id: string, word: Word, reason: string): void {
  const command = given.value.get(id);
  if (command) keep(hear(command, word, serverNowS(), reason));
}

function keep(command: Command): void {
  const kept = new Map(given.value).set(command.id, command);
  const [oldest] = kept.keys();
  if (kept.size > KEPT && oldest !== undefined) kept.delete(oldest);
  given.value = kept;
}
