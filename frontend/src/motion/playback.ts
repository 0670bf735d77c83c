/**
 * The moment that is shown of one vehicle: the server's clock, less a delay just long enough that its
 * next heartbeat has normally arrived. It runs evenly; where the delay changes, its speed bends, and
 * its direction never turns.
 */
import type { AtvView } from "../api/types";

/** Vehicles say where they are once per factory second at work, else every fifth (protocol, heartbeats). */
const WORKING_BEAT_S = 1;
const OTHER_BEAT_S = 5;
/** Frames are gathered for a tenth of a second, and a network is not even. */
const MARGIN_S = 0.25;
/** How much quicker and slower than real time a vehicle may be shown until its delay is right. */
const HURRY = 0.5;
const EASE = 0.4;
/** Further off than this (a hidden tab, another server) it is better to begin anew. */
const LOST_S = 10;

/** @param speed factory seconds per real second */
export function delayS(status: AtvView["status"], speed: number): number {
  const beat = status === "working" ? WORKING_BEAT_S : OTHER_BEAT_S;
  return beat / Math.max(speed, 0.25) + MARGIN_S;
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
  if (Math.abs(behind) > LOST_S) return wantedS;
  if (resting) return Math.max(atS, wantedS);
  if (behind > 0) return atS + passedS + Math.min(behind, passedS * HURRY);
  return atS + passedS - Math.min(-behind, passedS * EASE);
}
