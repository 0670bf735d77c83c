/** What can be said of when a vehicle hands over; a sentence is said only in the state in which it is true. Pure. */
import type { AtvView } from "../../../api/types";

/** What is not worth a word, in factory seconds. */
const PUNCTUAL_S = 2;

export type Arrival =
  /** Nothing is heard of it, or it stands: nobody knows. */
  | { readonly kind: "silent" | "stands" }
  /** It said a time that has passed. */
  | { readonly kind: "overdue"; readonly atS: number; readonly byS: number }
  /** It waits for others: it cannot know how long. */
  | { readonly kind: "heldUp"; readonly lateS: number | null }
  | { readonly kind: "expected"; readonly atS: number; readonly word: "onTime" | "late" | "early" | null; readonly byS: number };

interface Asked {
  /** When it says that it hands over. */
  readonly dueAtS: number;
  /** When its bid said so; null where that is not known. */
  readonly promisedAtS: number | null;
  readonly lost: boolean;
  readonly atv: Pick<AtvView, "status" | "problem">;
  /** Whether it waits for others on its way. */
  readonly waits: boolean;
  readonly nowS: number;
  /** Factory seconds per real second. */
  readonly speed: number;
}

/** @returns spans in factory seconds */
export function arrivalOf({ atv, dueAtS, lost, nowS, promisedAtS, speed, waits }: Asked): Arrival {
  if (lost) return { kind: "silent" };
  if (atv.status === "stopped" || atv.status === "error" || atv.problem !== "") return { kind: "stands" };
  // As it stands now: what has passed is no time at which it will come.
  const lateS = promisedAtS === null ? null : (Math.max(dueAtS, nowS) - promisedAtS) * speed;
  if (waits) return { kind: "heldUp", lateS: lateS !== null && lateS > PUNCTUAL_S ? lateS : null };
  const overS = (nowS - dueAtS) * speed;
  if (overS > PUNCTUAL_S) return { kind: "overdue", atS: dueAtS, byS: overS };
  const word = lateS === null ? null : Math.abs(lateS) <= PUNCTUAL_S ? "onTime" : lateS > 0 ? "late" : "early";
  return { kind: "expected", atS: dueAtS, word, byS: Math.abs(lateS ?? 0) };
}
