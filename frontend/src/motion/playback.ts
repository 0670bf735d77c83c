/**
 * The moment that is shown of one vehicle: the server's clock, less a delay just long enough that its
 * next heartbeat has normally arrived. It runs evenly; where the delay changes, its speed bends, and
 * its direction never turns.
 */
/** Frames are gathered for a tenth of a second, and a network is not even. */
const MARGIN_S = 0.25;
/** How much quicker and slower than real time a vehicle may be shown until its delay is right. */
const HURRY = 0.5;
const EASE = 0.4;
/** Further off than this (a hidden tab, another server) it is better to begin anew. */
const AFRESH_S = 10;

/**
 * @param beatS factory seconds between two heartbeats of the vehicle
 * @param speed factory seconds per real second
 */
export function delayS(beatS: number, speed: number): number {
  return beatS / Math.max(speed, 0.25) + MARGIN_S;
}

/**
 * The next moment to show.
 *
 * @param atS the moment that is shown now
 * @param wantedS the moment that should be shown
 * @param passedS real time since the last picture
 * @param resting whether the vehicle stands: then any later moment looks the same
 */
export function nextMoment(atS: number, wantedS: number, passedS: number, resting: boolean): number {
  const behind = wantedS - (atS + passedS);
  if (Math.abs(behind) > AFRESH_S) return wantedS;
  if (resting) return Math.max(atS, wantedS);
  if (behind > 0) return atS + passedS + Math.min(behind, passedS * HURRY);
  return atS + passedS - Math.min(-behind, passedS * EASE);
}
