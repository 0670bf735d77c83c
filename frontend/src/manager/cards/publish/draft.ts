/** An order that is being written: what it needs, what is wrong with it, what is sent. Pure. */
import type { FieldError, OrderDraft, PlantFile } from "../../../api/types";
import type { Priority } from "../../orders/priority";

export interface Draft {
  readonly product: string;
  readonly quantity: string;
  readonly customer: string;
  readonly reference: string;
  /** As a datetime-local field has it: local time without a zone. */
  readonly due: string;
  readonly priority: Priority;
}

export type Field = keyof Draft;
export type Complaint = "needProduct" | "needQuantity" | "needCustomer" | "needFuture";

/** The gateway's own limit. */
export const MOST_PIECES = 100_000;

/** The chosen product; none once it cannot be ordered any more. */
export function chosenOf(chosen: string, products: readonly { readonly id: string }[]): string {
  return products.some(({ id }) => id === chosen) ? chosen : "";
}

export function checkDraft(draft: Draft, nowS: number): Partial<Record<Field, Complaint>> {
  const complaints: Partial<Record<Field, Complaint>> = {};
  if (draft.product === "") complaints.product = "needProduct";
  if (quantityOf(draft) === null) complaints.quantity = "needQuantity";
  if (draft.customer.trim() === "") complaints.customer = "needCustomer";
  if (draft.due !== "" && !(Date.parse(draft.due) / 1000 > nowS)) complaints.due = "needFuture";
  return complaints;
}

export function quantityOf(draft: Draft): number | null {
  if (!/^\d+$/.test(draft.quantity.trim())) return null;
  const quantity = Number(draft.quantity);
  return quantity >= 1 && quantity <= MOST_PIECES ? quantity : null;
}

export function orderOf(draft: Draft, release: boolean): OrderDraft {
  const order: OrderDraft = {
    customer: draft.customer.trim(),
    items: [{ product: draft.product, quantity: Number(draft.quantity) }],
    priority: draft.priority,
    release,
  };
  if (draft.reference.trim() !== "") order.reference = draft.reference.trim();
  if (draft.due !== "") order.due_at = new Date(draft.due).toISOString();
  return order;
}

/** At which field the gateway's complaint is shown; null where it is about none of them. */
export function fieldOf(error: FieldError): Field | null {
  const parts = error.field.split(/[.[\]/]+/).filter(Boolean);
  const name = parts.at(-1) === "due_at" ? "due" : parts.at(-1);
  return FIELDS.find((field) => field === name) ?? null;
}

const FIELDS: readonly Field[] = ["product", "quantity", "customer", "reference", "due", "priority"];

export interface Maker {
  readonly id: string;
  readonly cycleS: number;
}

export function makersOf(plant: PlantFile, product: string): Maker[] {
  return plant.machines.flatMap((machine) =>
    machine.makes
      .filter((making) => making.product === product)
      .map((making) => ({ id: machine.id, cycleS: making.cycle_s })),
  );
}

export interface Need {
  readonly name: string;
  readonly pieces: number;
  /** Containers that vehicles will have to bring. */
  readonly lots: number;
}

/** What has to be brought for it; nothing for an impossible quantity. */
export function needsOf(plant: PlantFile, product: string, quantity: number | null): Need[] {
  if (quantity === null) return [];
  const bill = plant.products.find((each) => each.id === product)?.bill ?? [];
  return bill.flatMap((line) => {
    const material = plant.materials.find((each) => each.id === line.material);
    if (!material) return [];
    const pieces = line.quantity * quantity;
    return [{ name: material.name, pieces, lots: Math.ceil(pieces / material.lot) }];
  });
}

/** Of the machines that cannot make it now: how many are silent or broken, and of how many nothing was heard yet. */
export function unableOf(
  offers: readonly { readonly machine: string; readonly available: boolean }[],
  heard: ReadonlyMap<string, unknown>,
): { lost: number; unheard: number } {
  const unable = offers.filter(({ available }) => !available);
  const unheard = unable.filter(({ machine }) => !heard.has(machine)).length;
  return { lost: unable.length - unheard, unheard };
}
