/** What is being done to people and keys: the forms' state, and the sending of it. */
import { signal } from "@preact/signals";
import { addPerson, giveSecret, type Key, type KeyDraft, letIn, makeKey, makeLoginLink, movePerson, type Person, revokeKey, type SecretKind } from "../../../api/people";
import { Problem } from "../../../api/problem";
import { Openings } from "../../../parts/openings";
import { afterSent, fieldsAfterSent } from "../../../parts/sent";
import { t } from "../../../text/views/people";
import { problemText, refusedText } from "../../problem-text";

type Priority = NonNullable<KeyDraft["priority"]>;

export type Role = "manager" | "operator";

/** Whom the sheet is about; null for somebody new. */
export const chosen = signal<Person | null>(null);
export const written = signal(somebody());
export const secret = signal("");
export const kind = signal<SecretKind>("pin");
/** A login link that was made for whom is chosen; empty for none. */
export const link = signal("");

export const key = signal(something());
/** The token of the key that was made; empty for none. */
export const token = signal("");
/** The address of its page, where it is a call button of one place; empty for none. */
export const page = signal("");
/** Which key somebody is asked about before it is taken back; empty for none. */
export const asked = signal("");
/** Why a key could not be taken back; empty for nothing. */
export const stays = signal("");

export const busy = signal(false);
/** What is wrong with fields, by the gateway's names of them. */
export const complaints = signal<Readonly<Record<string, string>>>({});
export const outcome = signal<{ good: boolean; text: string } | null>(null);

function somebody() {
  return { id: "", name: "", role: "operator" as Role, areas: [] as string[] };
}

function something() {
  return { name: "", scopes: [] as string[], days: "", places: [] as string[], items: [] as string[], open: "", openEach: "", priority: "normal" as Priority };
}

function forget(): void {
  complaints.value = {};
  outcome.value = null;
}

export function edit(change: Partial<ReturnType<typeof somebody>>): void {
  written.value = { ...written.value, ...change };
  forget();
}

export function editKey(change: Partial<ReturnType<typeof something>>): void {
  key.value = { ...key.value, ...change };
  forget();
}

export function editSecret(change: string): void {
  secret.value = change;
  forget();
}

const fields = () => ({ chosen: chosen.value, written: written.value, kind: kind.value, secret: secret.value });

/** Of the sheet of one person. Complaints are those of the sheet that is open, so opening one leaves the other. */
export const openings = new Openings({
  read: fields,
  write(of: ReturnType<typeof fields>) {
    keyOpenings.begin();
    fill(of.chosen);
    [written.value, kind.value, secret.value] = [of.written, of.kind, of.secret];
  },
  complain,
  tell: ({ chosen: person, written: { id, name } }, error) => refusedText(person?.name ?? (name.trim() || id.trim() || t("people.add")), error),
});

/** Of the sheet of a key. */
export const keyOpenings = new Openings({
  read: () => key.value,
  write(of) {
    openings.begin();
    key.value = of;
    token.value = page.value = "";
    forget();
  },
  complain,
  tell: ({ name }, error) => refusedText(name.trim() || t("people.keyAdd"), error),
});

/** @param person null for somebody new */
export function begin(person: Person | null): void {
  openings.begin();
  keyOpenings.begin();
  fill(person);
}

function fill(person: Person | null): void {
  chosen.value = person;
  written.value = person ? writtenOf(person) : somebody();
  secret.value = "";
  kind.value = person?.role === "manager" ? "password" : "pin";
  link.value = "";
  forget();
}

function writtenOf(person: Person): ReturnType<typeof somebody> {
  return { ...person, role: person.role === "manager" ? "manager" : "operator", areas: [...person.areas] };
}

/** The sheet goes on with what has become of the person; what was written since stays in it. */
async function goOn(act: () => Promise<Person>, isOpen: () => boolean): Promise<void> {
  const sent = fields();
  const person = await act();
  if (!isOpen()) return;
  const since = fields();
  fill(person);
  written.value = fieldsAfterSent(sent.written, since.written, written.value);
  kind.value = afterSent(sent.kind, since.kind, kind.value);
  secret.value = afterSent(sent.secret, since.secret, "");
}

export function beginKey(): void {
  openings.begin();
  keyOpenings.begin();
  key.value = something();
  token.value = page.value = "";
  forget();
}

/** With or without one, in the order in which they were chosen. */
export function ticked(list: readonly string[], one: string, on: boolean): string[] {
  return on ? [...list, one] : list.filter((each) => each !== one);
}

export const add = (): Promise<boolean> =>
  ask(openings, async (isOpen) => {
    const { areas, id, name, role } = written.value;
    await goOn(() => addPerson({ id: id.trim(), name: name.trim() || id.trim(), role, areas: role === "manager" ? [] : areas }), isOpen);
    return t("people.added");
  });

export const makeLink = (person: Person): Promise<boolean> =>
  ask(openings, async (isOpen) => {
    const made = await makeLoginLink(person.id);
    // It lets in whoever has it: it is never shown for somebody else.
    if (isOpen()) link.value = made;
    return "";
  });

export const give = (person: Person): Promise<boolean> =>
  ask(openings, async (isOpen) => {
    await goOn(() => giveSecret(person.id, kind.value, secret.value), isOpen);
    return t("people.given");
  });

export const move = (person: Person): Promise<boolean> =>
  ask(openings, async (isOpen) => {
    await goOn(() => movePerson(person.id, written.value.areas), isOpen);
    return t("people.moved");
  });

export const setMay = (person: Person, may: boolean): Promise<boolean> =>
  ask(openings, async (isOpen) => {
    await goOn(() => letIn(person.id, may), isOpen);
    return t(may ? "people.enabled" : "people.disabled");
  });

export const addKey = (): Promise<boolean> =>
  ask(keyOpenings, async (isOpen) => {
    const { days, items, name, open, openEach, places, priority, scopes } = key.value;
    const limits = calls(scopes) ? { places, items, open_max: numberOf(open), open_each_max: numberOf(openEach), priority } : {};
    // The gateway says best which of them it does not know.
    const made = await makeKey({ name: name.trim(), scopes: scopes as never, days: numberOf(days), ...limits });
    // It is shown this one time, whatever is open.
    token.value = made.token;
    page.value = made.page_url ?? "";
    if (isOpen()) key.value = something();
    return "";
  });

export async function takeBack({ id, name }: Key): Promise<void> {
  if (busy.value) return;
  busy.value = true;
  stays.value = "";
  try {
    await revokeKey(id);
    asked.value = "";
  } catch (error) {
    stays.value = refusedText(name, error);
  } finally {
    busy.value = false;
  }
}

/** Whether a key with these may call for transports: only such a one has limits of that. */
export const calls = (scopes: readonly string[]): boolean => scopes.includes("transports:call");

/** @returns null for nothing written; what is no number as it was written, for the gateway says best what is wrong with it */
function numberOf(written: string): number | null {
  const text = written.trim();
  return text === "" ? null : /^\d+$/.test(text) ? Number(text) : (text as unknown as number);
}

/** @param act returns what the sheet tells when it is done; empty for nothing */
async function ask(sheet: Pick<typeof openings, "send">, act: (isOpen: () => boolean) => Promise<string>): Promise<boolean> {
  if (busy.value) return false;
  busy.value = true;
  forget();
  const done = await sheet.send(async (isOpen) => {
    const text = await act(isOpen);
    if (text !== "" && isOpen()) outcome.value = { good: true, text };
  });
  busy.value = false;
  return done;
}

function complain(error: unknown): void {
  const errors = error instanceof Problem ? error.errors : [];
  complaints.value = Object.fromEntries(errors.map(({ field, reason }) => [field.split("[")[0] ?? "", reason]));
  if (errors.length === 0) outcome.value = { good: false, text: t("people.failed", { reason: problemText(error) }) };
}
