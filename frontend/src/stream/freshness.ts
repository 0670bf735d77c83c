/** How old the picture is, in words that a person acts on. */

/** A frame comes at least once a second; three missing ones are worth a look. */
export const AMBER_AFTER_S = 3;
/** From here on the picture must not be taken for the plant. */
export const STALE_AFTER_S = 5;

export type Freshness = "connecting" | "live" | "amber" | "stale" | "offline";

/**
 * @param ageS seconds since the last frame; null before the first one
 * @param connected whether the socket is open
 */
export function freshnessOf(ageS: number | null, connected: boolean): Freshness {
  if (ageS === null) return connected ? "connecting" : "offline";
  if (!connected) return ageS > STALE_AFTER_S ? "offline" : "amber";
  if (ageS > STALE_AFTER_S) return "stale";
  return ageS > AMBER_AFTER_S ? "amber" : "live";
}

/** Whether the map must be shown as a thing of the past. */
export function isPast(freshness: Freshness): boolean {
  return freshness === "stale" || freshness === "offline";
}
