/** Forms that somebody has opened on a card: they outlive the card's way to another place. */
import { signal } from "@preact/signals";

export const REASONS = ["maintenance", "repair", "cleaning", "place"] as const;

/** Why a vehicle or machine is to go out of service, as far as it was said. */
export interface ServiceForm {
  readonly reason: (typeof REASONS)[number] | null;
  readonly afterWork: boolean;
}

/** By vehicle or machine. */
export const forms = signal<ReadonlyMap<string, ServiceForm>>(new Map());

/** Open or change a form; null closes it. */
export function setForm(id: string, form: ServiceForm | null): void {
  const after = new Map(forms.peek());
  if (form === null) after.delete(id);
  else after.set(id, form);
  forms.value = after;
}
