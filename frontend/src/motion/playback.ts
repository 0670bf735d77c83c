/**
 * The moment that the map shows: the server's clock, less a delay just long enough that the next
 * heartbeat has normally arrived. It runs evenly; a change of the delay bends its speed, never its
 * direction.
 */

/** Vehicles at work say where they are once per factory second (protocol, heartbeats). */
const HEARTBEAT_S = 1;
/** Frames are gathered for a tenth of a second, and a network is not even. */
const MARGIN_S = 0.25;
/** A delay is corrected at this part of real time: too little to be seen. */
const BEND = 0.15;
/** Further off than this (a hidden tab, another server) it is quicker to begin anew. */
const LOST_S = 4;

/** @param speed factory seconds per real second */
export function delayS(speed: number): number {
  return HEARTBEAT_S / Math.max(speed, 0.25) + MARGIN_S;
}

export class Playback {
  #atS: number | null = null;
  #localS = 0;

  /**
   * The moment to show.
   *
   * @param localS this browser's clock, which runs evenly
   * @param serverS the server's clock as it is known now; better knowledge makes it jump
   */
  at(localS: number, serverS: number, delay: number): number {
    const wanted = serverS - delay;
    const passed = Math.max(0, localS - this.#localS);
    this.#localS = localS;
    if (this.#atS === null || Math.abs(wanted - this.#atS) > LOST_S) {
      this.#atS = wanted;
    } else {
      const error = wanted - (this.#atS + passed);
      const bend = Math.min(passed * BEND, Math.abs(error));
      this.#atS += passed + Math.sign(error) * bend;
    }
    return this.#atS;
  }

  /** The moment shown last. */
  get shownS(): number {
    return this.#atS ?? 0;
  }

  reset(): void {
    this.#atS = null;
  }
}
