/** Vehicles that have left: their cards stay while a hand may be over them, and as long as somebody fills in a form there. Pure. */
import type { AtvView } from "../../api/types";
import { KEPT_MS } from "../stop/places";

export interface Left {
  /** As it was heard last. */
  readonly atv: AtvView;
  /** When it was seen to be away; null while it is here. */
  readonly atMs: number | null;
}

/**
 * @param before what this gave last
 * @param present the vehicles that are near
 * @param open those with an open form
 * @returns all that are near, and those that have left and stay for now
 */
export function stayed(
  before: ReadonlyMap<string, Left>,
  present: ReadonlyMap<string, AtvView>,
  open: ReadonlySet<string>,
  nowMs: number,
): ReadonlyMap<string, Left> {
  const after = new Map<string, Left>([...present].map(([id, atv]) => [id, { atv, atMs: null }]));
  for (const [id, { atMs, atv }] of before) {
    if (present.has(id)) continue;
    const sinceMs = atMs ?? nowMs;
    if (open.has(id) || nowMs - sinceMs < KEPT_MS) after.set(id, { atv, atMs: sinceMs });
  }
  return after;
}
