/** The form's state, and the sending of it. */
import { signal } from "@preact/signals";
import { defineProduct } from "../../../../api/products";
import { Problem } from "../../../../api/problem";
import { Openings } from "../../../../parts/openings";
import { fieldsAfterSent } from "../../../../parts/sent";
import { t } from "../../../../text/views/products";
import { plantAsked } from "../../../plant-asked";
import { problemText, refusedText } from "../../../problem-text";
import { plant } from "../../../state";
import { draftOf, empty, partOf, type ProductAnswer, twice, type Written, writtenOf } from "./draft";

export const written = signal<Written>(empty(""));
export const complaints = signal<Readonly<Record<string, string>>>({});
export const sending = signal(false);
export const outcome = signal<{ good: boolean; text: string } | null>(null);

export function edit(change: Partial<Written>): void {
  written.value = { ...written.value, ...change };
  complaints.value = {};
  outcome.value = null;
}

export const openings = new Openings<Written>({
  read: () => written.value,
  write(fields) {
    written.value = fields;
    complaints.value = {};
    outcome.value = null;
  },
  complain: (error) => { complain(error, written.value); },
  tell: ({ id, name }, error) => refusedText(name.trim() || id.trim(), error),
});

export function begin(product: ProductAnswer | null): void {
  openings.begin();
  written.value = product ? writtenOf(product) : empty(plant.value?.vehicle_types[0]?.abilities[0] ?? "");
  complaints.value = {};
  outcome.value = null;
}

export async function send(): Promise<boolean> {
  const wanted = written.value;
  const wrong: Record<string, string> = {};
  for (const part of ["bill", "machines"] as const) {
    const double = twice(wanted[part]);
    if (double !== null) wrong[part] = t("products.twice", { what: double });
  }
  if (wanted.id.trim() === "") wrong.id = t("products.needId");
  complaints.value = wrong;
  outcome.value = null;
  if (sending.value || Object.keys(wrong).length > 0) return false;
  sending.value = true;
  const done = await openings.send(async (isOpen) => {
    const defined = await defineProduct(wanted.id.trim(), draftOf(wanted), wanted.etag);
    if (isOpen()) {
      written.value = fieldsAfterSent(wanted, written.value, writtenOf(defined));
      outcome.value = { good: true, text: t("products.defined", { name: defined.name, revision: defined.revision }) };
    }
    // Whatever names products by the plant knows it at once.
    void plantAsked.now();
  });
  sending.value = false;
  return done;
}

function complain(error: unknown, wanted: Written): void {
  const at: Record<string, string> = {};
  const elsewhere: string[] = [];
  for (const each of error instanceof Problem ? error.errors : []) {
    const part = partOf(each.field, wanted);
    if (part === "") elsewhere.push(`${each.field}: ${each.reason}`);
    else at[part] = [at[part], each.reason].filter(Boolean).join("; ");
  }
  complaints.value = at;
  if (error instanceof Problem && error.kind === "exists") {
    complaints.value = { id: t("products.exists") };
  } else if (Object.keys(at).length === 0 || elsewhere.length > 0) {
    const reason = elsewhere.length > 0 ? elsewhere.join("; ") : problemText(error);
    outcome.value = { good: false, text: t("products.failed", { reason }) };
  }
}
