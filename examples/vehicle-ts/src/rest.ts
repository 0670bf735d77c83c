/** What a vehicle does without work: claim a berth with nobody in the middle, stand there, and charge in time. */

import type { BerthClaimed } from './messages.ts';
import type { Hands } from './carriage.ts';

const SETTLE_S = 4;
const SEEK_AGAIN_S = 30;
const CONTEST_S = 1;
const TAKEN_S = 60;
const CHARGE_BELOW_FRAC = 0.6;
const CHARGED_FRAC = 0.95;

/** What a rest needs of its vehicle, beside what a carriage does. */
export interface Bed extends Hands {
  readonly atv: string;
  claim(claim: BerthClaimed): void;
  listen(berth: string): void;
  ignore(berth: string): void;
}

export class Rest {
  /** The berth that it holds or is driving to; empty for none. */
  berth = '';
  #bed: Bed;
  #standing = false;
  #claimed_frac = 0;
  #charge = 0;
  #takenUntil_s = new Map<string, number>();
  #settles_s = Infinity;
  #sure_s = Infinity;

  constructor(bed: Bed) {
    this.#bed = bed;
  }

  get charging(): boolean {
    return this.#charge !== 0;
  }

  /** There is no work: look for a place in a moment. */
  soon(): void {
    this.#settles_s = this.#bed.now_s() + SETTLE_S;
  }

  /** There is work, or it is leaving. */
  stop(): void {
    this.#leave();
    this.#charge = 0;
    this.#settles_s = this.#sure_s = Infinity;
  }

  arrived(): void {
    if (!this.berth || this.#bed.plant.dockOf(this.berth) !== this.#bed.driver.node) return;
    this.#standing = true;
    if (this.#bed.plant.chargers.includes(this.berth)) this.#beginCharge();
  }

  /** A charge has ended, well or not; false when the action was another. */
  actionEnded(order: number, well: boolean): boolean {
    if (!this.#charge || order !== this.#charge) return false;
    this.#charge = 0;
    if (!well) this.#leave();
    this.soon();
    return true;
  }

  tick(): void {
    const { driver, body } = this.#bed;
    const now_s = this.#bed.now_s();
    const battery_frac = body.state.battery_frac;
    if (now_s >= this.#sure_s) {
      // Nobody has objected.
      this.#sure_s = Infinity;
      if (this.berth && !driver.go(this.#bed.plant.dockOf(this.berth)!, now_s)) this.arrived();
    }
    if (this.charging && battery_frac >= CHARGED_FRAC) {
      this.#charge = 0;
      this.#leave();
      this.#settles_s = now_s;
    }
    const seeking = this.#sure_s < Infinity || this.#settles_s < Infinity || (this.berth && !this.#standing);
    if (battery_frac < CHARGE_BELOW_FRAC && !this.charging && !seeking) this.#settles_s = now_s;
    if (now_s >= this.#settles_s) this.#settle(now_s, battery_frac);
  }

  /** Somebody wants a berth. Who stands there keeps it, else the emptier battery, else the smaller id. */
  hear(claim: BerthClaimed): void {
    if (claim.berth !== this.berth || claim.atv === this.#bed.atv) return;
    if (this.#winsOver(claim)) {
      this.#say();
      return;
    }
    this.#takenUntil_s.set(claim.berth, this.#bed.now_s() + TAKEN_S);
    this.#charge = 0;
    this.#sure_s = Infinity;
    this.#leave();
    this.#settles_s = this.#bed.now_s();
  }

  #winsOver(claim: BerthClaimed): boolean {
    if (this.#standing !== claim.standing) return this.#standing;
    if (this.#claimed_frac !== claim.battery_frac) return this.#claimed_frac < claim.battery_frac;
    return this.#bed.atv < claim.atv;
  }

  #settle(now_s: number, battery_frac: number): void {
    this.#settles_s = Infinity;
    const { plant, driver } = this.#bed;
    const wantsCharge = battery_frac < CHARGE_BELOW_FRAC;
    if (this.charging || (this.#standing && !wantsCharge)) return;
    const free = (wantsCharge ? plant.chargers : plant.parkings).filter(
      (berth) => (this.#takenUntil_s.get(berth) ?? 0) <= now_s,
    );
    const far_m = (berth: string) => driver.wayTo(plant.dockOf(berth)!)?.length_m ?? Infinity;
    const nearest = free.sort((a, b) => far_m(a) - far_m(b))[0];
    this.#leave();
    if (nearest === undefined || far_m(nearest) === Infinity) {
      driver.halt(now_s);
      this.#settles_s = now_s + SEEK_AGAIN_S;
      return;
    }
    this.berth = nearest;
    this.#claimed_frac = battery_frac;
    this.#bed.listen(nearest);
    this.#say();
    this.#sure_s = now_s + CONTEST_S;
  }

  #beginCharge(): void {
    const charger = this.berth;
    this.#charge = this.#bed.driver.act((order) => ({ kind: 'Charge', order, charger }));
  }

  #say(): void {
    const { berth } = this;
    const claim = { berth, atv: this.#bed.atv, battery_frac: this.#claimed_frac, standing: this.#standing };
    this.#bed.claim({ type: 'BerthClaimed', ...claim });
  }

  #leave(): void {
    if (this.berth) this.#bed.ignore(this.berth);
    this.berth = '';
    this.#standing = false;
  }
}
