/**
 * One contract as its carrier lives it: approach, load, carry, unload, hand over (docs/protocol.md, "A transport").
 *
 *     approaching -> loading -> carrying -> unloading -> handing_over -> ended
 *          |            |          |            |
 *          +-- ended    +----------+------------+--> returning -> ended     (superseded, withdrawn, released)
 *
 * A question is repeated until it is answered; a coordinator that answers nothing ten times has failed. At a storage that
 * has nothing the vehicle waits as long as it can keep its promise, and gives the task back then.
 */

import type { Body } from './body.ts';
import type { Driver } from './driver.ts';
import type { Answer, Message, Phase } from './messages.ts';
import type { Contract } from './notes.ts';
import type { Plant } from './plant.ts';

const ASK_AGAIN_S = 3;
const HELD_ASK_AGAIN_S = 5;
const WAITS_AT_LEAST_S = 15;
const RETRY_S = 5;
const GIVE_UP_AFTER = 10;
const TRIES = 3;

/** What a job needs of its vehicle. */
export interface Hands {
  readonly plant: Plant;
  readonly driver: Driver;
  readonly body: Body;
  now_s(): number;
  send(to: string, message: Message): void;
  /** Write the contract down; called before anything that follows from it is said. */
  keep(contract: Contract): void;
}

export class TransportJob {
  contract: Contract;
  /** Why it has ended; empty while it lasts. */
  ended = '';
  due_s: number;
  #hands: Hands;
  #station: string;
  #loaded = false;
  #action = 0;
  #asked = 0;
  #failed = 0;
  #full = new Set<string>();
  /** When to ask again (plant clock). */
  #wakes_s = Infinity;
  #givenBack = false;
  #why = { reason: '', short: '', detail: '' };
  /** Since when it stands at its source (plant clock). */
  #stands_s = Infinity;

  constructor(contract: Contract, hands: Hands) {
    this.contract = contract;
    this.#hands = hands;
    this.#station = contract.source;
    this.due_s = contract.promised_s;
  }

  get isGivenBack(): boolean {
    return this.#givenBack;
  }

  get brief(): object {
    const { task, epoch, coordinator, phase, work } = this.contract;
    const { item, quantity } = work;
    return { task, epoch, role: 'primary', coordinator, phase, item, quantity, due_s: this.due_s };
  }

  begin(): void {
    this.#enter('approaching', this.contract.source);
    this.#drive();
  }

  /** Go on after a restart, from what is on board: the coordinator is told again that the contract was taken. */
  resume(load: string): void {
    const { phase, cancelled, coordinator } = this.contract;
    this.#loaded = load === this.contract.work.item;
    if (!cancelled) this.#hands.send(coordinator, this.accepted);
    if (cancelled) this.#giveUp();
    else if (this.#loaded) this.#carry();
    else if (phase === 'unloading' || phase === 'handing_over') this.#handOver();
    else if (phase === 'carrying') this.#resign('load_gone');
    else this.begin();
  }

  get accepted(): Message {
    const { task, epoch, promised_s, number } = this.contract;
    return { type: 'Accepted', task, epoch, role: 'primary', finish_s: promised_s, number };
  }

  // --- what happens ---

  arrived(): void {
    const { phase } = this.contract;
    if (this.#givenBack) return;
    if (phase === 'approaching') {
      this.#enter('loading', this.contract.source);
      this.#askToLoad();
    } else if (phase === 'carrying') {
      this.#enter('unloading', this.contract.work.destination);
      this.#askToUnload();
    } else if (phase === 'returning') {
      this.#drop('');
    }
  }

  wayRefused(): void {
    this.#wakeIn(RETRY_S);
  }

  actionDone(order: number): void {
    if (order !== this.#action) return;
    const { phase, cancelled } = this.contract;
    this.#action = this.#failed = 0;
    this.#loaded = phase === 'loading';
    if (phase === 'loading') cancelled ? this.#return() : this.#carry();
    else if (cancelled) this.#end(cancelled);
    else this.#handOver();
  }

  actionFailed(order: number, reason: string): void {
    if (order !== this.#action) return;
    const { phase, cancelled } = this.contract;
    this.#action = 0;
    this.#failed += 1;
    if (cancelled && phase !== 'returning') this.#giveUp();
    else if (this.#failed < TRIES) this.#wakeIn(RETRY_S);
    else if (phase === 'returning') {
      this.#full.add(this.#station);
      this.#return();
    } else if (phase === 'unloading' && this.#isGated) this.#resign('gate_refused', reason);
    else this.#wakeIn(RETRY_S);
  }

  onAnswer(answer: Answer): void {
    const { epoch, phase } = this.contract;
    // Superseded tells the epoch that is right now; all others speak of this one.
    if (answer.type === 'Superseded') {
      if (!(answer.epoch > 0 && answer.epoch < epoch)) this.cancel('superseded');
      return;
    }
    if (answer.epoch !== epoch) return;
    if (answer.type === 'Withdrawn') this.cancel('withdrawn');
    else if (answer.type === 'HandoverAccepted' && phase === 'handing_over') this.#end('handed over');
    else if (answer.type === 'DockHeld' && this.#waitsAt(answer.station)) this.#wait(answer.reason ?? '');
    else if (answer.type === 'DockOpened' && this.#waitsAt(answer.station)) {
      this.#wakes_s = Infinity;
      this.#transfer();
    } else return;
    this.#asked = 0;
  }

  /** The contract is void: end, and bring the load to a storage if there is one. */
  cancel(reason: string): void {
    if (this.contract.cancelled || this.ended) return;
    this.#change({ cancelled: reason });
    this.#wakes_s = Infinity;
    if (!this.#action) this.#giveUp();
  }

  /** Stand, and ask the coordinator to let another one carry it; in vain once the load is on board. */
  giveBack(reason = 'graceful_shutdown', short = '', detail = ''): void {
    const { phase, cancelled } = this.contract;
    if (this.#givenBack || cancelled || this.#action || (phase !== 'approaching' && phase !== 'loading')) return;
    this.#givenBack = true;
    this.#why = { reason, short, detail };
    this.#asked = 0;
    this.#hands.driver.halt(this.#hands.now_s());
    this.#sayGivenBack();
  }

  /** Time has passed. */
  tick(load: string): void {
    if (this.#hands.now_s() < this.#wakes_s) return;
    this.#wakes_s = Infinity;
    const { phase } = this.contract;
    if (this.#asked >= GIVE_UP_AFTER) {
      this.#asked = 0;
      if (phase === 'handing_over') this.#end('handed over to a silent machine');
      else if (this.#fetches && !this.#givenBack) this.giveBack('source_silent', this.#station);
      else this.#resign('coordinator_silent');
    } else if (load && load !== this.contract.work.item) this.#resign('other_load', load);
    else if (Boolean(load) !== this.#loaded) {
      // A person has taken the load off, or an action of an earlier life has ended.
      this.#loaded = Boolean(load);
      if (this.#loaded) this.#carry();
      else if (this.contract.work.goal) this.#resign('load_gone');
      else this.begin();
    } else if (this.#givenBack) this.#sayGivenBack();
    else if (phase === 'loading') this.#askToLoad();
    else if (phase === 'unloading') this.#askToUnload();
    else if (phase === 'handing_over') this.#sayHandover();
    else this.#drive();
  }

  // --- how it is done ---

  #enter(phase: Phase, station: string): void {
    this.#change({ phase });
    this.#station = station;
    this.#failed = 0;
    this.#stands_s = Infinity;
  }

  #change(changes: Partial<Contract>): void {
    this.contract = { ...this.contract, ...changes };
    this.#hands.keep(this.contract);
  }

  #dock(place: string): string {
    const dock = this.#hands.plant.dockOf(place) ?? this.contract.work.node;
    if (!dock) throw new Error(`nobody knows where ${place} is`);
    return dock;
  }

  #drive(): void {
    const { driver } = this.#hands;
    const { work, phase, source } = this.contract;
    const now_s = this.#hands.now_s();
    const away = driver.go(this.#dock(this.#station), now_s);
    const there_s = away ? driver.arrives_s : now_s;
    const loaded_s = driver.way(this.#dock(source), this.#dock(work.destination))?.duration_s ?? 0;
    const { load_s, unload_s } = driver.type;
    if (phase === 'approaching') this.due_s = there_s + load_s + loaded_s + unload_s;
    else if (phase === 'carrying') this.due_s = there_s + unload_s;
    if (!away) this.arrived();
  }

  #carry(): void {
    this.#enter('carrying', this.contract.work.destination);
    this.#drive();
  }

  #handOver(): void {
    this.#enter('handing_over', this.contract.work.destination);
    this.#sayHandover();
  }

  /** A machine opens its dock to the carrier that it expects, the station of a storage to whom it has promised the load. */
  #askToLoad(): void {
    if (this.#stands_s === Infinity) this.#stands_s = this.#hands.now_s();
    this.#askForDock();
  }

  /** Whether it stands at a storage and is to load there. */
  get #fetches(): boolean {
    const { phase, source, coordinator } = this.contract;
    return phase === 'loading' && source !== coordinator;
  }

  /** Ask again later; at a storage that has nothing, as long as the promise can be kept and a moment longer. */
  #wait(reason: string): void {
    const { work, source, promised_s } = this.contract;
    const { driver } = this.#hands;
    const now_s = this.#hands.now_s();
    const loaded_s = driver.way(this.#dock(source), this.#dock(work.destination))?.duration_s ?? 0;
    const late = now_s + driver.type.load_s + loaded_s + driver.type.unload_s > promised_s;
    if (this.#fetches && late && now_s >= this.#stands_s + WAITS_AT_LEAST_S) this.giveBack('dock_held', source, reason);
    else this.#wakeIn(HELD_ASK_AGAIN_S);
  }

  /** At a delivery warehouse the gate decides, which counts. */
  #askToUnload(): void {
    if (this.#isGated) this.#drop(this.contract.work.goal ?? '');
    else this.#askForDock();
  }

  get #isGated(): boolean {
    return this.#hands.plant.isDelivery(this.contract.work.destination);
  }

  #askForDock(): void {
    const { task, epoch, coordinator, work } = this.contract;
    const station = this.#station;
    // A storage has no other word of the task if its station has lost its notes.
    const load = station === coordinator ? {} : { item: work.item, quantity: work.quantity };
    this.#ask({ type: 'Docked', task, epoch, station, ...load }, station);
  }

  #sayHandover(): void {
    const { task, epoch, work } = this.contract;
    this.#ask({ type: 'Handover', task, epoch, quantity: work.quantity });
  }

  #sayGivenBack(): void {
    const { task, epoch } = this.contract;
    this.#ask({ type: 'Resigned', task, epoch, role: 'primary', ...this.#why });
  }

  #ask(question: Message, whom = this.contract.coordinator): void {
    this.#asked += 1;
    this.#hands.send(whom, question);
    this.#wakeIn(ASK_AGAIN_S);
  }

  #wakeIn(wait_s: number): void {
    this.#wakes_s = this.#hands.now_s() + wait_s;
  }

  #waitsAt(station: string): boolean {
    const { phase } = this.contract;
    const asking = phase === 'loading' || phase === 'unloading';
    return asking && station === this.#station && !this.#action && !this.#givenBack;
  }

  #transfer(): void {
    if (this.contract.phase === 'loading') this.#pick();
    else this.#drop(this.contract.work.goal ?? '');
  }

  #pick(): void {
    const { source: station, work } = this.contract;
    const { item, quantity } = work;
    this.#action = this.#hands.driver.act((order) => ({ kind: 'Pick', order, station, item, quantity }));
  }

  #drop(goal: string): void {
    const station = this.#station;
    this.#action = this.#hands.driver.act((order) => ({ kind: 'Drop', order, station, goal }));
  }

  #resign(reason: string, detail = ''): void {
    const { task, epoch, coordinator, cancelled } = this.contract;
    if (!cancelled && !this.ended)
      this.#hands.send(coordinator, { type: 'Resigned', task, epoch, role: 'primary', reason, detail });
    this.cancel(reason);
  }

  #giveUp(): void {
    if (this.#loaded) this.#return();
    else this.#end(this.contract.cancelled);
  }

  /** Bring the load to the nearest place that keeps it. */
  #return(): void {
    const { plant, driver } = this.#hands;
    const refuges = plant.refugesOf(this.contract.work.item);
    const roomy = refuges.filter((refuge) => !this.#full.has(refuge));
    if (!roomy.length) this.#full.clear();
    const far_s = (refuge: string) => driver.wayTo(this.#dock(refuge))?.duration_s ?? Infinity;
    const nearest = (roomy.length ? roomy : refuges).reduce((a, b) => (far_s(b) < far_s(a) ? b : a));
    this.#enter('returning', nearest);
    this.#drive();
  }

  #end(reason: string): void {
    this.ended = reason || 'ended';
    this.#wakes_s = Infinity;
  }
}
