/** One vehicle: beats, bids, takes one contract at a time, rests, and obeys people. It watches nobody. */

import type { Body, Report } from './body.ts';
import type { Bus } from './bus.ts';
import { TransportJob } from './transport-job.ts';
import type { Driver } from './driver.ts';
import type { Answer, Award, DwellPointClaimed, Message, Status, TaskAnnounced } from './messages.ts';
import type { Contract, Notes } from './notes.ts';
import type { CommandHandling } from './command-handling.ts';
import type { Plant } from './plant.ts';
import { quote } from './pricing.ts';
import { IdlePositioning, type Bed } from './rest.ts';

const WORKING_BEAT_S = 1;
const IDLE_BEAT_S = 5;
const SOFTWARE = 'vehicle-ts 1';

export class Vehicle implements Bed {
  readonly atv: string;
  readonly plant: Plant;
  readonly driver: Driver;
  readonly body: Body;
  readonly now_s: () => number;
  #bus: Bus;
  #notes: Notes;
  #commands: CommandHandling;
  #life: number;
  #seq = 0;
  #beats_s = 0;
  #cell = '';
  #job: TransportJob | undefined;
  #rest: IdlePositioning;
  #problem: string;
  #draining = false;
  /** Told what has happened, in a line. */
  readonly #tell: (line: string) => void;

  constructor(
    atv: string,
    parts: {
      plant: Plant;
      driver: Driver;
      body: Body;
      bus: Bus;
      notes: Notes;
      commands: CommandHandling;
      now_s: () => number;
      tell: (line: string) => void;
    },
  ) {
    this.atv = atv;
    this.plant = parts.plant;
    this.driver = parts.driver;
    this.body = parts.body;
    this.now_s = parts.now_s;
    this.#bus = parts.bus;
    this.#notes = parts.notes;
    this.#commands = parts.commands;
    this.#tell = parts.tell;
    this.#life = parts.notes.kept.life;
    this.#problem = parts.body.state.problem;
    this.#rest = new IdlePositioning(this);
    this.body.attach((report) => this.#hearReport(report));
    this.#move();
    const { contract } = parts.notes.kept;
    if (contract) this.#go(contract, (job) => job.resume(this.body.state.load));
    else if (this.body.state.load) this.#bringBack();
    else this.#rest.soon();
    this.#beat();
  }

  // --- what its parts use ---

  send(to: string, message: Message): void {
    this.#bus.send(to, message);
  }

  keep(contract: Contract): void {
    this.#notes.write({ contract });
  }

  claim(claim: DwellPointClaimed): void {
    this.#bus.publish(`${this.plant.id}/dwell-point/${claim.dwell_point}`, claim);
  }

  listen(dwellPoint: string): void {
    this.#bus.subscribe(`${this.plant.id}/dwell-point/${dwellPoint}`);
  }

  ignore(dwellPoint: string): void {
    this.#bus.unsubscribe(`${this.plant.id}/dwell-point/${dwellPoint}`);
  }

  // --- time passes ---

  /** Called several times a second. */
  tick(): void {
    this.#step((job) => job.tick(this.body.state.load));
    if (!this.#job && !this.#isStuck && !this.#draining) this.#rest.tick();
    if (this.now_s() >= this.#beats_s) this.#beat();
  }

  /** Take nothing new; give the task back unless the load is on board. */
  leave(): void {
    this.#draining = true;
    this.#rest.stop();
    this.#step((job) => job.giveBack());
    if (!this.#job) this.driver.halt(this.now_s());
    this.#beat();
  }

  /** Whether nothing holds it any more. */
  get mayGo(): boolean {
    return this.#draining && (this.#isStuck || (!this.#job && !this.driver.isDriving));
  }

  // --- others speak ---

  onMessage(sender: string, message: Message): void {
    switch (message.type) {
      case 'TaskAnnounced':
        this.#hearAnnounced(message);
        break;
      case 'Award':
        this.#hearAward(sender, message);
        break;
      case 'Release': {
        const { role, task, epoch, number } = message;
        const contract = this.#contractWith(sender, task);
        if (role === 'primary' && contract?.epoch === epoch && contract.number === (number ?? 0))
          this.#step((job) => job.cancel('released'));
        break;
      }
      case 'DockOpened':
      case 'DockHeld':
        // Of a dock only its owner speaks: a machine, or the station of a storage, which both have the place's name.
        if (sender === message.station && this.#job?.contract.task === message.task)
          this.#step((job) => job.onAnswer(message as Answer));
        break;
      case 'HandoverAccepted':
      case 'Confirmed':
      case 'Superseded':
      case 'Withdrawn':
        if (this.#contractWith(sender, message.task)) this.#step((job) => job.onAnswer(message as Answer));
        break;
      case 'DwellPointClaimed':
        this.#rest.onClaim(message);
        break;
      case 'VehicleCommand': {
        const refused = this.#commands.onCommand(message, this.now_s());
        const { command } = message;
        this.send(sender, { type: 'CommandAnswered', command, done: !refused, reason: refused || null });
        this.#tell(`${message.kind} ${command}: ${refused || 'done'}`);
        if (!this.#isStuck && !this.#job) this.#rest.soon();
        this.#beat();
        break;
      }
      case 'EventsAsked':
        // This vehicle tells no facts: what it does is told by those whom it works for.
        this.send(sender, { type: 'EventsKept', incarnation: message.incarnation, first: 1, last: 0, life: this.#life });
        break;
      default:
        break;
    }
  }

  #hearAnnounced(message: TaskAnnounced): void {
    const { work, role, task, epoch, coordinator } = message;
    const here = this.driver.place;
    const far_m = Math.hypot((message.x_m ?? 0) - here.x_m, (message.y_m ?? 0) - here.y_m);
    if (role !== 'primary' || work.kind !== 'transport' || !this.#isFree || far_m > (message.radius_m ?? 0)) return;
    const offer = quote(this.plant, this.driver, this.body.state.battery_frac, work, this.now_s(), message.deadline_s);
    if (!offer) return;
    const { cost, finish_s, source } = offer;
    this.send(coordinator, { type: 'Bid', task, epoch, role, round: message.round ?? 1, cost, finish_s, source });
  }

  #hearAward(sender: string, award: Award): void {
    const { task, epoch, role, work } = award;
    const number = award.number ?? 1;
    const held = this.#contractWith(sender, task);
    if (held && held.epoch === epoch && !held.cancelled) {
      // Its answer was lost; this award is the one that binds now.
      this.#job!.contract = { ...held, number };
      this.keep(this.#job!.contract);
      this.send(sender, this.#job!.accepted);
      return;
    }
    const decline = (reason: string) => this.send(sender, { type: 'Declined', task, epoch, role, reason, number });
    if (role !== 'primary') return decline('watching_enough');
    if (work.kind !== 'transport') return decline('ability');
    if (!this.#isFree) return decline(this.#job ? 'busy' : 'not_fit');
    const sources = award.source ? [award.source] : work.sources;
    const battery_frac = this.body.state.battery_frac;
    const offer = quote(this.plant, this.driver, battery_frac, { ...work, sources }, this.now_s(), award.deadline_s);
    if (!offer) return decline('deadline');
    const { source, finish_s: promised_s } = offer;
    const contract: Contract = {
      ...{ task, epoch, work, coordinator: sender, source, promised_s, number },
      phase: 'approaching',
      cancelled: '',
    };
    this.keep(contract);
    this.#tell(`takes ${task}: ${work.quantity} ${work.item} from ${source} to ${work.destination}`);
    this.#rest.stop();
    this.#go(contract, (job) => {
      this.send(sender, job.accepted);
      job.begin();
    });
  }

  #contractWith(sender: string, task: string): Contract | undefined {
    const contract = this.#job?.contract;
    return contract?.task === task && contract.coordinator === sender ? contract : undefined;
  }

  // --- its body reports ---

  #hearReport(report: Report): void {
    const way = this.driver.onReport(report);
    this.#move();
    if (way === 'arrived') {
      if (this.#job) this.#step((job) => job.arrived());
      else this.#rest.arrived();
    } else if (way === 'refused') {
      if (this.#job) this.#step((job) => job.wayRefused());
      else this.#rest.soon();
    } else if (report.kind === 'ActionDone') {
      if (!this.#rest.actionEnded(report.order, true)) this.#step((job) => job.actionDone(report.order));
    } else if (report.kind === 'ActionFailed') {
      if (!this.#rest.actionEnded(report.order, false))
        this.#step((job) => job.actionFailed(report.order, report.reason));
    } else if (report.kind === 'ProblemRaised' || report.kind === 'ProblemCleared') {
      this.#problem = report.kind === 'ProblemRaised' ? report.reason : '';
      if (this.#problem) this.#commands.takeBack();
      this.#beat();
    }
  }

  /** Listen where it is: announcements go to cells. */
  #move(): void {
    const cell = this.plant.cellOf(this.driver.place);
    if (cell === this.#cell) return;
    if (this.#cell) this.#bus.unsubscribe(`${this.plant.id}/task/${this.#cell}`);
    this.#bus.subscribe(`${this.plant.id}/task/${cell}`);
    this.#cell = cell;
  }

  // --- its contract ---

  get #isStuck(): boolean {
    return this.#commands.stopped || this.#problem !== '';
  }

  get #isFree(): boolean {
    return !this.#job && !this.#isStuck && !this.#draining && !this.body.state.load;
  }

  #go(contract: Contract, begin: (job: TransportJob) => void): void {
    this.#job = new TransportJob(contract, this);
    this.#step(begin);
    // Its coordinator counts the seconds of silence from now on.
    this.#beat();
  }

  /** A load without a contract is one of an earlier life: bring it back, for nobody. */
  #bringBack(): void {
    const { load, load_quantity } = this.body.state;
    const sources = this.plant.refugesOf(load);
    const destination = sources[0]!;
    const work = { kind: 'transport', item: load, quantity: load_quantity, sources, destination, ability: '' } as const;
    const found = { task: `${this.atv}-found`, epoch: 0, work, coordinator: this.atv, source: destination, promised_s: 0 };
    const contract: Contract = { ...found, number: 0, phase: 'returning', cancelled: 'nobody knows of this load' };
    this.#go(contract, (job) => job.resume(load));
  }

  #step(step: (job: TransportJob) => void): void {
    const job = this.#job;
    if (!job) return;
    const { phase } = job.contract;
    step(job);
    if (this.#draining && !job.ended) job.giveBack();
    if (job.ended) {
      this.#tell(`${job.contract.task}: ${job.ended}`);
      this.#job = undefined;
      this.#notes.write({ contract: null });
      this.#rest.soon();
    }
    if (job.ended || job.contract.phase !== phase) this.#beat();
  }

  // --- what others see ---

  get #status(): Status {
    if (this.#commands.stopped) return 'stopped';
    if (this.#problem) return 'error';
    if (this.#job) return 'working';
    return this.#rest.charging ? 'charging' : 'idle';
  }

  #beat(): void {
    const { state } = this.body;
    const isReliedOn = this.#job !== undefined || this.#problem !== '';
    this.#beats_s = this.now_s() + (isReliedOn ? WORKING_BEAT_S : IDLE_BEAT_S);
    this.#seq += 1;
    this.#bus.publish(`${this.plant.id}/hb/atv/${this.atv}`, {
      type: 'AtvHeartbeat',
      atv: this.atv,
      incarnation: this.#life,
      seq: this.#seq,
      at_s: this.now_s(),
      status: this.#status,
      pose: state.pose,
      node: this.driver.node,
      speed_mps: state.speed_mps,
      battery_frac: state.battery_frac,
      load: state.load,
      load_quantity: state.load_quantity,
      task: this.#job?.brief ?? null,
      way: this.driver.ahead,
      dwell_point: this.#rest.dwellPoint,
      speed_limit_frac: this.#notes.kept.speed_frac,
      acknowledged: this.#commands.acknowledged,
      problem: this.#problem,
      software: SOFTWARE,
      draining: this.#draining,
    });
  }
}
