/**
 * The ways that a stop goes: the gateway's own, and one that is for stops alone, which nothing else can fill. Both are
 * asked at once under one name, and a vehicle answers what comes twice as it did before.
 */

/** The other way, as the page's `dray-stop` tells; none where this browser cannot reach it. */
export function stopOrigins(): readonly string[] {
  const told = document.querySelector<HTMLMetaElement>('meta[name="dray-stop"]')?.content;
  return told ? [told] : [];
}

/** Why a way did not lead to an answer: a status of HTTP, or 0 where no answer came. */
interface Failure {
  readonly status: number;
  readonly kind: string;
}

/**
 * Goes all ways at once and takes the first answer. Where there is none, the failure of the way that may have led
 * furthest is thrown: a person must not be told that a stop did not leave when it may have arrived.
 */
export async function firstWord<T>(ways: readonly string[], go: (way: string) => Promise<T>): Promise<T> {
  const tries = ways.map((way) => go(way));
  try {
    return await Promise.any(tries);
  } catch {
    const ends = await Promise.allSettled(tries);
    const reasons = ends.map((each): unknown => (each.status === "rejected" ? each.reason : null));
    // Of two that are alike, the gateway's own, which comes first, knows more.
    throw reasons.reduce((furthest, reason) => (reach(reason) > reach(furthest) ? reason : furthest));
  }
}

/** How far a stop may have got: not out of here, refused at the door, into the plant, to the vehicle. */
function reach(reason: unknown): number {
  const { status, kind } = (reason ?? {}) as Partial<Failure>;
  if (status === undefined) return 2;
  if (status === 0) return kind === "not-sent" ? 0 : 2;
  if (status === 504) return 3;
  return status >= 500 ? 2 : 1;
}
