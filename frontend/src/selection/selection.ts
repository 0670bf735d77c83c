/**
 * What the manager looks at: one place (machine or other), one vehicle, and perhaps one task. The two
 * right-hand cards stay filled side by side, as in the paper's Figure 4.
 */
import { signal } from "@preact/signals";

export interface Chosen {
  readonly kind: "atv" | "machine" | "place" | "task" | "lane" | "order";
  readonly id: string;
}

export interface Selection {
  readonly atv: string | null;
  /** A machine, a storage, a warehouse or a charger. */
  readonly place: Chosen | null;
  readonly task: string | null;
  /** Who watches over the vehicle: it takes over when that one fails. */
  readonly standby: string | null;
  /** The order for which all this is done; null for material, which is for whatever order comes. */
  readonly order: string | null;
  /** A lane of the map, to close it. */
  readonly lane: string | null;
  /** Which of them was chosen last: the auction follows it. */
  readonly latest: Chosen["kind"] | null;
}

export const NOTHING: Selection = { atv: null, place: null, task: null, standby: null, order: null, lane: null, latest: null };

export const selection = signal<Selection>(NOTHING);

export function withChosen(before: Selection, chosen: Chosen): Selection {
  const latest = chosen.kind;
  switch (chosen.kind) {
    case "atv":
      return { ...before, atv: chosen.id, task: null, latest };
    case "lane":
      return { ...before, lane: before.lane === chosen.id ? null : chosen.id };
    case "task":
      return { ...before, task: chosen.id, latest };
    case "order":
      return { ...before, order: chosen.id, task: null, latest };
    default:
      return { ...before, place: chosen, task: null, latest };
  }
}

/** What else is chosen with something; a panel that knows more puts its own here. */
let tell = withChosen;

export function tellStories(by: typeof withChosen): void {
  tell = by;
}

export function choose(chosen: Chosen): void {
  selection.value = tell(selection.value, chosen);
}

/** What was chosen last, to be chosen again; null for nothing, and for a lane, which is only marked. */
export function lastChosen({ atv, latest, order, place, task }: Selection): Chosen | null {
  switch (latest) {
    case "atv":
      return atv === null ? null : { kind: "atv", id: atv };
    case "task":
      return task === null ? null : { kind: "task", id: task };
    case "order":
      return order === null ? null : { kind: "order", id: order };
    case null:
    case "lane":
      return null;
    default:
      return place;
  }
}
