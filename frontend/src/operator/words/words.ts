/**
 * What people say has happened at a machine or a station, until that has answered. It is kept in the browser and said again under its
 * name, so that it counts once however often the tablet, the gateway or the place is away.
 */
import { computed, signal } from "@preact/signals";
import { commandMachine, commandStation, newKey } from "../../api/client";
import type { CommandAnswer } from "../../api/types";
import { Problem } from "../../api/problem";
import { recall, remember } from "../../memory";
import { problemText, refusalText } from "../problem-text";
import { me } from "../session/session";
import type { Choice } from "./choice";
import { wordsIn } from "./kept";

const AGAIN_MS = 5_000;

/** A count that comes later than this tells of another moment: it is not said again. */
const COUNT_LASTS_MS = 30_000;

const KEPT = "operator.words.";

export interface Word extends Choice {
  readonly key: string;
  readonly place: string;
  /** At a station; else at a machine. */
  readonly station: boolean;
  /** The number is right, however far it is from the expected one. */
  readonly sure: boolean;
  readonly saidMs: number;
  /** Far from this number, which was expected: somebody is asked. */
  readonly doubted?: string;
}

/** Where something is said. */
export interface At {
  readonly id: string;
  readonly station: boolean;
}

export interface Said {
  readonly word: Word;
  readonly became: "counted" | "refused" | "lost";
  readonly reason: string;
}

/** Not settled yet, the oldest first. */
const kept = signal<readonly Word[]>([]);

/** Not answered yet. */
export const waiting = computed(() => kept.value.filter((word) => word.doubted === undefined));

/** The first that somebody is asked about. */
export const doubted = computed(() => kept.value.find((word) => word.doubted !== undefined) ?? null);

/** What became of the last one. */
export const last = signal<Said | null>(null);

let person = "";
let underway = false;
let timer: ReturnType<typeof setTimeout> | undefined;

/** Goes on with what this person has said here before. */
export function goOn(): void {
  const id = me.value?.id ?? "";
  if (id === "" || id === person) return;
  person = id;
  kept.value = read();
  void pass();
}

export function say({ id, station }: At, choice: Choice, sure = false): void {
  const word = { ...choice, key: newKey(), place: id, station, sure, saidMs: Date.now() };
  last.value = null;
  keep([...read(), word]);
  void pass();
}

/** Answers the question about a number that is far from the expected one. */
export function answer(isRight: boolean): void {
  const asked = doubted.value;
  if (asked === null) return;
  const { item, kind, place, quantity, saidMs, station, vehicle } = asked;
  if (isRight && isStale(kind, saidMs)) {
    end(asked, "lost", "");
    return;
  }
  forget(asked);
  if (isRight) say({ id: place, station }, { item, kind, quantity, vehicle }, true);
}

async function pass(): Promise<void> {
  if (underway) return;
  underway = true;
  clearTimeout(timer);
  const tried = new Set<string>();
  for (let word = next(tried); word !== undefined; word = next(tried)) {
    tried.add(word.key);
    await tell(word);
  }
  underway = false;
  if (waiting.value.length > 0) timer = setTimeout(() => void pass(), AGAIN_MS);
}

function next(tried: ReadonlySet<string>): Word | undefined {
  return waiting.value.find(({ key }) => !tried.has(key));
}

async function tell(word: Word): Promise<void> {
  const { key, kind, saidMs } = word;
  if (isStale(kind, saidMs)) {
    end(word, "lost", "");
    return;
  }
  try {
    const { detail, done, reason } = await passOn(word);
    if (!done && reason === "unlikely") {
      keep(read().map((each) => (each.key === key ? { ...each, doubted: detail } : each)));
    } else end(word, done ? "counted" : "refused", refusalText({ reason: reason ?? "", detail }));
  } catch (error) {
    if (!mayComeThrough(error)) end(word, "refused", problemText(error));
  }
}

async function passOn({ item, key, kind, place, quantity, station, sure, vehicle }: Word): Promise<CommandAnswer> {
  const said = { item, quantity, vehicle, sure, command: key };
  if (station && kind !== "made" && kind !== "scrapped") return await commandStation(place, { kind, ...said });
  return await commandMachine(place, { kind, ...said });
}

function isStale(kind: Word["kind"], saidMs: number): boolean {
  return kind === "stock_is" && Date.now() - saidMs > COUNT_LASTS_MS;
}

/** Whether it may be heard when it is said again: nobody has said no. */
function mayComeThrough(error: unknown): boolean {
  return !(error instanceof Problem) || error.status < 400 || error.status >= 500 || error.status === 401 || error.status === 429;
}

function end(word: Word, became: Said["became"], reason: string): void {
  forget(word);
  last.value = { word, became, reason };
}

function forget({ key }: Word): void {
  keep(read().filter((each) => each.key !== key));
}

function keep(words: readonly Word[]): void {
  kept.value = words;
  remember(KEPT + person, JSON.stringify(words));
}

/** Also what another tab of the same person has said; where a browser keeps nothing, what this page knows. */
function read(): readonly Word[] {
  const written = recall(KEPT + person);
  return (written === null ? null : wordsIn(written)) ?? kept.value;
}
