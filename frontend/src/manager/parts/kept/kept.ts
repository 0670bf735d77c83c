/** For how long history is kept, as far as a list reaches back. Pure but for the question. */
import { bodyOf, gateway } from "../../../api/gateway";
import type { components } from "../../../api/types";

export type Kept = components["schemas"]["KeptView"];

export async function fetchKept(): Promise<readonly Kept[]> {
  return (await bodyOf(gateway.GET("/api/kept"))).items;
}

/** Some seconds: a list that begins with the oldest there is, does not reach beyond it. */
const NEAR_S = 60;

export interface Reach {
  readonly how: "gone" | "begins";
  /** Before this moment there is nothing. */
  readonly atS: number;
}

/**
 * Whether somebody asks for what was before all that there is, and why it is not there.
 *
 * @param fromS the earliest moment that is asked for
 */
export function reachOf({ gone_before_at_s: goneS, since_at_s: sinceS }: Kept, fromS: number): Reach | null {
  if (goneS !== null && fromS < goneS - NEAR_S) return { how: "gone", atS: goneS };
  if (sinceS !== null && fromS < sinceS - NEAR_S) return { how: "begins", atS: sinceS };
  return null;
}

/** The earliest moment that a list is asked for by two fields of date and time; null where it asks for all. */
export function earliestS(since: string | undefined, until: string | undefined): number | null {
  const found = [since, until].map((each) => new Date(each ?? "").getTime() / 1000).filter((each) => !Number.isNaN(each));
  return found.length === 0 ? null : Math.min(...found);
}
