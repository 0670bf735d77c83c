/** The server's wall clock as this browser can know it: its own clock plus an offset it learns. */

/** How fast a smaller delay seen long ago is forgotten: the two clocks may drift apart. */
const FORGET_S_PER_S = 0.001;

export class ServerClock {
  /** @param ownS our own wall clock when our `localS` was 0: it counts as long as nothing was heard */
  constructor(readonly ownS = 0) {}

  #offsetS: number | null = null;
  #heardS = 0;

  /**
   * A frame said that the server's clock was `serverS` when ours was `localS`. Frames arrive late,
   * never early, so the largest difference seen is nearest to the truth.
   */
  note(serverS: number, localS: number): void {
    const offset = serverS - localS;
    const kept = (this.#offsetS ?? -Infinity) - FORGET_S_PER_S * (localS - this.#heardS);
    this.#offsetS = Math.max(offset, kept);
    this.#heardS = localS;
  }

  /** The server's clock at our `localS`; our own clock as long as nothing was heard. */
  at(localS: number): number {
    return localS + (this.#offsetS ?? this.ownS);
  }

  /** After a reconnect the server may be another one. */
  reset(): void {
    this.#offsetS = null;
  }
}
