/** A plain transport as somebody calls for it: the form's state, and the sending of it. */
import { signal } from "@preact/signals";
import { newKey } from "../../../api/client";
import { Problem } from "../../../api/problem";
import { callTransport, type TransportDraft } from "../../../api/transports";
import type { FieldError } from "../../../api/types";
import { fieldsAfterSent } from "../../../parts/sent";
import { format, t } from "../../../text/views/transports";
import type { Priority } from "../../orders/priority";
import { problemText } from "../../problem-text";

export interface Written {
  readonly item: string;
  /** What has no master data, as people call it; empty for a material. */
  readonly thing: string;
  readonly quantity: string;
  readonly from: string;
  readonly to: string;
  readonly priority: Priority;
  /** In the reader's zone, as the browser writes it; empty for none. */
  readonly due: string;
  /** Likewise. */
  readonly begin: string;
  readonly vehicle: string;
  readonly only: boolean;
  readonly ability: string;
}

export const EMPTY: Written = { item: "", thing: "", quantity: "", from: "", to: "", priority: "normal", due: "", begin: "", vehicle: "", only: true, ability: "" };

export const written = signal<Written>(EMPTY);
export const complaints = signal<Readonly<Record<string, string>>>({});
/** What one vehicle carries at most, where more was asked for: it can be asked for in several loads; 0 for nothing to split. */
export const splitBy = signal(0);
export const busy = signal(false);
/** `called`: which one it has become. */
export const outcome = signal<{ good: boolean; text: string; called?: string } | null>(null);

/** The same for every try at what is written: a transport whose answer was lost is not called twice. */
let key = "";

export function edit(change: Partial<Written>): void {
  written.value = { ...written.value, ...change };
  complaints.value = {};
  splitBy.value = 0;
  outcome.value = null;
  key = "";
}

/** Loads that are offered for one call: as many as a call button's key may have open at first; more are a slip of the keyboard. */
export const LOADS_MOST = 50;

/** In which loads so many pieces come, where one has so many at most: the last has what is left. */
export function loadsOf(pieces: number, most: number): number[] {
  return Array.from({ length: Math.ceil(pieces / most) }, (_, load) => Math.min(most, pieces - load * most));
}

/** The loads of so many pieces in short, as the gateway's refusal has them: 2 x 40 + 20. */
export function loadsText(pieces: number, most: number): string {
  const [full, rest] = [Math.floor(pieces / most), pieces % most];
  return `${format.count(full)} x ${format.count(most)}${rest === 0 ? "" : ` + ${format.count(rest)}`}`;
}

/** What is sent. What is no number goes as it was written, for the gateway says best what is wrong with it. */
export function draftOf({ ability, begin, due, from, item, only, priority, quantity, thing, to, vehicle }: Written): TransportDraft {
  const pieces = quantity.trim();
  const moment = (written: string): string | null => (written === "" ? null : new Date(written).toISOString());
  const or = (text: string): string | null => (text === "" ? null : text);
  return {
    from: or(from), to: or(to), item: or(item), thing: or(thing.trim()), priority, vehicle: or(vehicle), vehicle_only: only, ability: or(ability),
    quantity: pieces === "" ? null : /^\d+$/.test(pieces) ? Number(pieces) : (pieces as unknown as number),
    due_at: moment(due), not_before: moment(begin),
  };
}

const PARTS: Readonly<Record<string, string>> = { due_at: "due", not_before: "begin", from: "from", to: "to", item: "item", thing: "thing", quantity: "quantity", vehicle: "vehicle", ability: "ability" };

/** Each complaint at its field, and those together that have none. */
export function complaintsOf(errors: readonly { field: string; reason: string }[]): { at: Record<string, string>; elsewhere: string } {
  const at: Record<string, string> = {};
  const elsewhere: string[] = [];
  for (const { field, reason } of errors) {
    const part = PARTS[field];
    if (part === undefined) elsewhere.push(`${field}: ${reason}`);
    else at[part] = [at[part], reason].filter(Boolean).join("; ");
  }
  return { at, elsewhere: elsewhere.join("; ") };
}

/** The most pieces of one load, where that is what is wrong; 0 else. */
export function mostOf(errors: readonly FieldError[]): number {
  const most = errors.length === 1 && errors[0]?.code === "load_too_large" ? Number(errors[0].values?.most) : 0;
  return Number.isFinite(most) ? most : 0;
}

/** @param most of one load: what is more is called for in several, each once, however often this is tried */
export async function send(most = 0): Promise<boolean> {
  if (busy.value) return false;
  busy.value = true;
  if (key === "") key = newKey();
  const [sent, tried] = [written.value, key];
  const draft = draftOf(sent);
  try {
    let id = "";
    if (most === 0) ({ id } = await callTransport(draft, tried));
    else for (const [load, quantity] of loadsOf(draft.quantity ?? 0, most).entries()) ({ id } = await callTransport({ ...draft, quantity }, `${tried}-${load}`));
    // Where it was called to or from is where the next one is called, most often.
    edit(fieldsAfterSent(sent, written.value, { ...EMPTY, from: sent.from, to: sent.to }));
    outcome.value = { good: true, text: t("called.sent", { id: "" }), called: id };
    return true;
  } catch (error) {
    const errors = error instanceof Problem ? error.errors : [];
    const { at, elsewhere } = complaintsOf(errors);
    splitBy.value = mostOf(errors);
    complaints.value = at;
    const reason = elsewhere === "" && Object.keys(at).length === 0 ? problemText(error) : elsewhere;
    outcome.value = reason === "" ? null : { good: false, text: t("called.failed", { reason }) };
    return false;
  } finally {
    busy.value = false;
  }
}
