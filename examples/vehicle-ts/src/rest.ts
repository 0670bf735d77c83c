/** What a vehicle does without work: claim a dwell point with nobody in the middle, stand there, and charge in time. */

import type { DwellPointClaimed } from './messages.ts';
import type { Hands } from './transport-job.ts';

const SETTLE_S = 4;
const SEEK_AGAIN_S = 30;
const CONTEST_S = 1;
const TAKEN_S = 60;
const CHARGE_BELOW_FRAC = 0.6;
const CHARGED_FRAC = 0.95;

/** What a rest needs of its vehicle, beside what a job does. */
export interface Bed extends Hands {
  readonly atv: string;
  claim(claim: DwellPointClaimed): void;
  listen(dwellPoint: string): void;
  ignore(dwellPoint: string): void;
}

export class IdlePositioning {
  /** The dwell point that it holds or is driving to; empty for none. */
  dwellPoint = '';
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

  /** There is work, or it is draining. */
  stop(): void {
    this.#leave();
    this.#charge = 0;
    this.#settles_s = this.#sure_s = Infinity;
  }

  arrived(): void {
    if (!this.dwellPoint || this.#bed.plant.dockOf(this.dwellPoint) !== this.#bed.driver.node) return;
    this.#standing = true;
    if (this.#bed.plant.chargers.includes(this.dwellPoint)) this.#beginCharge();
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
      if (this.dwellPoint && !driver.go(this.#bed.plant.dockOf(this.dwellPoint)!, now_s)) this.arrived();
    }
    if (this.charging && battery_frac >= CHARGED_FRAC) {
      this.#charge = 0;
      this.#leave();
      this.#settles_s = now_s;
    }
    const seeking = this.#sure_s < Infinity || this.#settles_s < Infinity || (this.dwellPoint && !this.#standing);
    if (battery_frac < CHARGE_BELOW_FRAC && !this.charging && !seeking) this.#settles_s = now_s;
    if (now_s >= this.#settles_s) this.#settle(now_s, battery_frac);
  }

  /** Somebody wants a dwell point. Who stands there keeps it, else the emptier battery, else the smaller id. */
  onClaim(claim: DwellPointClaimed): void {
    if (claim.dwell_point !== this.dwellPoint || claim.atv === this.#bed.atv) return;
    if (this.#winsOver(claim)) {
      this.#say();
      return;
    }
    this.#takenUntil_s.set(claim.dwell_point, this.#bed.now_s() + TAKEN_S);
    this.#charge = 0;
    this.#sure_s = Infinity;
    this.#leave();
    this.#settles_s = this.#bed.now_s();
  }

  #winsOver(claim: DwellPointClaimed): boolean {
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
      (dwellPoint) => (this.#takenUntil_s.get(dwellPoint) ?? 0) <= now_s,
    );
    const far_m = (dwellPoint: string) => driver.wayTo(plant.dockOf(dwellPoint)!)?.length_m ?? Infinity;
    const nearest = free.sort((a, b) => far_m(a) - far_m(b))[0];
    this.#leave();
    if (nearest === undefined || far_m(nearest) === Infinity) {
      driver.halt(now_s);
      this.#settles_s = now_s + SEEK_AGAIN_S;
      return;
    }
    this.dwellPoint = nearest;
    this.#claimed_frac = battery_frac;
    this.#bed.listen(nearest);
    this.#say();
    this.#sure_s = now_s + CONTEST_S;
  }

  #beginCharge(): void {
    const charger = this.dwellPoint;
    this.#charge = this.#bed.driver.act((order) => ({ kind: 'Charge', order, charger }));
  }

  #say(): void {
    const { dwellPoint } = this;
    const claim = { dwell_point: dwellPoint, atv: this.#bed.atv, battery_frac: this.#claimed_frac, standing: this.#standing };
    this.#bed.claim({ type: 'DwellPointClaimed', ...claim });
  }

  #leave(): void {
    if (this.dwellPoint) this.#bed.ignore(this.dwellPoint);
    this.dwellPoint = '';
    this.#standing = false;
  }
}
