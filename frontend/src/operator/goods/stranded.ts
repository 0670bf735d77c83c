/** Goods on board of failed vehicles, which wait for a person's word. Pure. */
import type { TaskView } from "../../api/types";

/** Transports whose goods wait, those first that are given up first. */
export function strandedOf(tasks: Iterable<TaskView>): readonly TaskView[] {
  return [...tasks]
    .filter(({ stranded }) => stranded !== null)
    .sort((a, b) => untilS(a) - untilS(b) || a.id.localeCompare(b.id));
}

function untilS({ stranded }: TaskView): number {
  return stranded?.until_at_s ?? Infinity;
}
