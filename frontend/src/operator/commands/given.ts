/** The commands that were given on this page, and what has become of them. */
import { computed, signal } from "@preact/signals";
import { commandAtv, commandMachine, commandStation, loadSeen, newKey } from "../../api/client";
import { NOT_SENT, Problem } from "../../api/problem";
import type { CommandAnswer, CommandRequest, CommandView, MachineCommandRequest, StationCommandRequest } from "../../api/types";
import { serverNowS, world } from "../../stream/stream";
import { t } from "../../text/operator";
import { problemText } from "../problem-text";
import { me } from "../session/session";
import { afterWord, type Command, fromPlant, type Kind, type Why, type Word } from "./life";

/** A card shows the last one of its vehicle: more than vehicles in an area are of no use. */
const KEPT = 100;

/** By id, the oldest first. */
const given = signal<ReadonlyMap<string, Command>>(new Map());

/** Those that the plant tells of, whoever gave them, and those that it has not heard of yet. */
export const all = computed(() => {
  const told = world.value?.commands ?? new Map<string, CommandView>();
  const unheard = [...given.value.values()].filter(({ id }) => !told.has(id));
  return [...[...told.values()].map((view) => fromPlant(view, given.value.get(view.id))), ...unheard];
});

const lastByAtv = computed(() => {
  const last = new Map<string, Command>();
  for (const command of all.value) if (isLater(command, last.get(command.atv))) last.set(command.atv, command);
  return last;
});

/** The last command to a vehicle, whoever gave it. */
export function lastOf(atv: string): Command | undefined {
  return lastByAtv.value.get(atv);
}

/** The command of this page that something was said about last. */
export const lastSaid = computed(() =>
  all.value
    .filter(({ id }) => given.value.has(id))
    .reduce<Command | undefined>((last, each) => (isLater(each, last) ? each : last), undefined),
);

function isLater(command: Command, than: Command | undefined): boolean {
  return than === undefined || command.atS >= than.atS;
}

/** Sends a command to a vehicle once, and never again: a person must know what became of it, and decide anew. */
export async function give(atv: string, request: CommandRequest): Promise<void> {
  await follow(atv, request, (command) => commandAtv(atv, { ...request, command }));
}

/** The same to a machine. */
export async function giveMachine(machine: string, request: MachineCommandRequest): Promise<void> {
  await follow(machine, request, (command) => commandMachine(machine, { ...request, command }));
}

/** The same to the station of a storage or warehouse. */
export async function giveStation(station: string, request: StationCommandRequest): Promise<void> {
  await follow(station, request, (command) => commandStation(station, { ...request, command }));
}

/** What somebody has seen of a load that was disputed, to the machine or station that waits for that word. */
export async function sayLoad(place: string, task: string, there: boolean): Promise<void> {
  await follow(place, { kind: there ? "load_there" : "load_missing" }, (command) => loadSeen(task, { there, command }));
}

/** What somebody has counted where a load is in doubt. */
export async function sayCounted({ load: task, place, station }: Counted, there: boolean): Promise<void> {
  const kind = there ? "load_there" : "load_missing";
  await follow(place, { kind }, (command) => (station ? commandStation(place, { kind, task, command }) : commandMachine(place, { kind, task, command })));
}

/** A load in doubt, where it perhaps lies. */
interface Counted {
  readonly load: string;
  readonly place: string;
  readonly station: boolean;
}

interface Request {
  readonly kind: Kind;
  readonly speed_frac?: number | null;
}

async function follow(atv: string, request: Request, send: (command: string) => Promise<CommandAnswer>): Promise<void> {
  const id = newKey();
  const { kind, speed_frac: speedFrac = null } = request;
  keep({ id, atv, kind, speedFrac, by: me.value?.name ?? "", stage: "sent", accepted: false, reason: "", detail: "", atS: serverNowS() });
  try {
    const answer = await send(id);
    tell(id, answer.done ? "done" : "declined", answer);
  } catch (error) {
    const [word, detail] = wordOf(error);
    tell(id, word, { reason: null, detail });
  }
}

function wordOf(error: unknown): [Word, string] {
  // An answer that was cut off half-way is none.
  if (!(error instanceof Problem)) return ["unanswered", t("command.unreachable")];
  if (error.kind === NOT_SENT) return ["unsent", t("command.unsent")];
  if (error.status === 0) return ["unanswered", t("command.unreachable")];
  if (error.status === 504) return ["silence", t("command.silent")];
  // A plant that is in trouble itself may have passed it on before.
  return [error.status >= 500 ? "unanswered" : "rejected", problemText(error)];
}

function tell(id: string, word: Word, why: Why): void {
  const command = given.value.get(id);
  if (command) keep(afterWord(command, word, serverNowS(), why));
}

function keep(command: Command): void {
  const kept = new Map(given.value).set(command.id, command);
  const [oldest] = kept.keys();
  if (kept.size > KEPT && oldest !== undefined) kept.delete(oldest);
  given.value = kept;
}
