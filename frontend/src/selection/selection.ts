/**
 * What the manager looks at: one place (machine or other), one vehicle, and perhaps one task. The two
 * right-hand cards stay filled side by side, as in the paper's Figure 4.
 */
import { signal } from "@preact/signals";

export interface Chosen {
  readonly kind: "atv" | "machine" | "place" | "task" | "lane";
  readonly id: string;
}

export interface Selection {
  readonly atv: string | null;
  /** A machine, a storage, a warehouse or a charger. */
  readonly place: Chosen | null;
  readonly task: string | null;
  /** A lane of the map, to close it. */
  readonly lane: string | null;
  /** Which of them was chosen last: the auction follows it. */
  readonly latest: Chosen["kind"] | null;
}

export const NOTHING: Selection = { atv: null, place: null, task: null, lane: null, latest: null };

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
    default:
      return { ...before, place: chosen, task: null, latest };
  }
}

export function choose(chosen: Chosen): void {
  selection.value = withChosen(selection.value, chosen);
}
