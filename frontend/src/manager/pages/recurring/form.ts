/** The form's state, and the sending of it. */
import { computed, signal } from "@preact/signals";
import { Problem } from "../../../api/problem";
import { addSchedule, changeSchedule, previewRuns, type Schedule } from "../../../api/schedules";
import { Openings } from "../../../parts/openings";
import { fieldsAfterSent } from "../../../parts/sent";
import { t } from "../../../text/views/recurring";
import { chosenOf } from "../../cards/publish/draft";
import { problemText, refusedText } from "../../problem-text";
import { plant } from "../../state";
import { calendarOf, daysOf, draftOf, empty, type Line, partOf, type Written, writtenOf } from "./draft";

/** What is changed; null for something new. */
export const before = signal<Schedule | null>(null);
export const written = signal<Written>(empty("UTC"));
/** The lines as they are shown and sent: a product that is gone is none. */
export const lines = computed<readonly Line[]>(() => {
  const products = plant.value?.products;
  if (products === undefined) return written.value.lines;
  return written.value.lines.map((line) => ({ ...line, product: chosenOf(line.product, products) }));
});
export const complaints = signal<Readonly<Record<string, string>>>({});
export const busy = signal(false);
export const outcome = signal<{ good: boolean; text: string } | null>(null);
/** The next moments, of the time zone in which they are told; null before they were asked for. */
export const runs = signal<{ zone: string; moments: readonly string[] } | null>(null);

export function edit(change: Partial<Written>): void {
  written.value = { ...written.value, ...change };
  forget();
}

export const openings = new Openings({
  read: () => ({ before: before.value, written: written.value }),
  write(fields) {
    [before.value, written.value] = [fields.before, fields.written];
    forget();
  },
  complain,
  tell: (fields, error) => refusedText(fields.written.name.trim() || (fields.before?.name ?? t("recurring.addTitle")), error),
});

export function begin(schedule: Schedule | null): void {
  openings.begin();
  before.value = schedule;
  written.value = schedule ? writtenOf(schedule) : empty(Intl.DateTimeFormat().resolvedOptions().timeZone);
  forget();
}

function forget(): void {
  complaints.value = {};
  outcome.value = null;
  runs.value = null;
}

export async function preview(): Promise<boolean> {
  const zone = written.value.zone.trim();
  return await ask(async (isOpen) => {
    const { holidays, holidaysOf } = written.value;
    const days = { holidays: daysOf(holidays), holidays_of: holidaysOf.trim() };
    const moments = await previewRuns({ calendar: calendarOf(written.value), time_zone: zone, ...days, count: 10 });
    if (isOpen()) runs.value = { zone, moments };
  });
}

export async function send(): Promise<boolean> {
  const [old, sent] = [before.value, written.value];
  const draft = draftOf({ ...sent, lines: lines.value });
  return await ask(async (isOpen) => {
    const kept = old === null ? await addSchedule({ ...draft, paused: false }) : await changeSchedule(old, draft);
    if (!isOpen()) return;
    before.value = kept;
    written.value = fieldsAfterSent(sent, written.value, writtenOf(kept));
    forget();
    outcome.value = { good: true, text: t("recurring.kept", { name: kept.name }) };
  });
}

async function ask(what: (isOpen: () => boolean) => Promise<void>): Promise<boolean> {
  if (busy.value) return false;
  busy.value = true;
  forget();
  const done = await openings.send(what);
  busy.value = false;
  return done;
}

function complain(error: unknown): void {
  const at: Record<string, string> = {};
  const elsewhere: string[] = [];
  for (const each of error instanceof Problem ? error.errors : []) {
    const part = partOf(each.field);
    if (part === "") elsewhere.push(`${each.field}: ${each.reason}`);
    else at[part] = [at[part], each.reason].filter(Boolean).join("; ");
  }
  complaints.value = at;
  if (Object.keys(at).length === 0 || elsewhere.length > 0) {
    const reason = elsewhere.length > 0 ? elsewhere.join("; ") : problemText(error);
    outcome.value = { good: false, text: t("recurring.failed", { reason }) };
  }
}
