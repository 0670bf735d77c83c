/** Dray's bus on a Zenoh session: envelopes, stamps, seals, and tokens of who is there (docs/agents.md, "On the bus"). */

import type { Message } from './messages.ts';
import { pack, unpack } from './msgpack.ts';
import { SealError, type Seals } from './seals.ts';
import type { Session } from './zenoh.ts';

const WIRE_VERSION = 2;
const BYTES_MAX = 65_536;

/** Who may say what to a vehicle; whatever is not here is refused. */
const SPEAKERS: Readonly<Record<string, readonly string[]>> = {
  TaskAnnounced: ['machine', 'strategist', 'station'],
  Award: ['machine', 'strategist', 'station'],
  Confirmed: ['machine', 'strategist', 'station'],
  Release: ['machine', 'strategist', 'station'],
  Superseded: ['machine', 'strategist', 'station'],
  Withdrawn: ['machine', 'strategist', 'station'],
  DockOpened: ['machine', 'station'],
  DockHeld: ['machine', 'station'],
  HandoverAccepted: ['machine', 'station'],
  DwellPointClaimed: ['atv'],
  VehicleCommand: ['gateway'],
  EventsAsked: ['gateway', 'historian'],
  ShutOut: ['gateway'],
};
const SIGNED_AS: Readonly<Record<string, string>> = { TaskAnnounced: 'coordinator', DwellPointClaimed: 'atv' };

export type Receive = (sender: string, message: Message) => void;

export class Bus {
  /** What came in and was not heard, by reason. */
  readonly refused = new Map<string, number>();
  readonly #session: Session;
  readonly #seals: Seals;
  readonly #receive: Receive;
  readonly #replaced: () => void;
  readonly #plant: string;
  readonly #agent: string;
  readonly #life: number;
  readonly #token: string;
  #said = new Map<string, number>();
  #shutOut: readonly string[] = [];
  #shutOutNumber = -1;

  constructor(
    session: Session,
    seals: Seals,
    who: { plant: string; agent: string; life: number },
    receive: Receive,
    replaced: () => void,
  ) {
    this.#session = session;
    this.#seals = seals;
    this.#plant = who.plant;
    this.#agent = who.agent;
    this.#life = who.life;
    this.#receive = receive;
    this.#replaced = replaced;
    const words = `${who.plant}/alive/${who.agent}/${who.life}`;
    this.#token = seals.vouch(words);
    session.watchTokens(`${who.plant}/alive/*/*/*`, (key, there) => there && this.#guard(() => this.#see(key)));
    session.subscribe(`${who.plant}/agent/@${who.agent}`, this.#onSample);
    session.subscribe(`${who.plant}/shut-out`, this.#onSample);
    session.declareToken(`${words}/${this.#token}`);
  }

  publish(key: string, message: Message): void {
    const where = this.#place(key);
    const data = this.#envelope(message);
    this.#put(where, data, this.#seals.seal(where, data));
  }

  /** Say it to one agent alone; an agent that nobody knows is silence. */
  send(to: string, message: Message): void {
    const where = this.#place(`${this.#plant}/agent/@${to}`);
    const written = this.#seals.write(this.#agent, to, where, this.#envelope(message));
    if (written) this.#put(where, written.letter, written.seal);
    else this.#count('no certificate of the reader is known yet');
  }

  subscribe(key: string): void {
    this.#session.subscribe(key, this.#onSample);
  }

  unsubscribe(key: string): void {
    this.#session.unsubscribe(key);
  }

  #place(key: string) {
    return { key, life: this.#life, number: (this.#said.get(key) ?? 0) + 1 };
  }

  #envelope(message: Message): Buffer {
    return Buffer.from(JSON.stringify({ v: WIRE_VERSION, from: this.#agent, m: message }));
  }

  #put({ key, life, number }: { key: string; life: number; number: number }, data: Buffer, seal: Buffer): void {
    if (this.#shutOut.includes(this.#agent)) return;
    this.#said.set(key, number);
    this.#session.put(key, data, pack([life, number, seal]));
  }

  #onSample = (key: string, payload: Buffer, attachment: Buffer): void =>
    this.#guard(() => {
      const [life, number, seal] = unpack(attachment) as [number, number, Buffer];
      const place = { key, life, number };
      const own = key === `${this.#plant}/agent/@${this.#agent}`;
      const letter = own ? this.#seals.read(seal, this.#agent, place, payload) : undefined;
      const data = letter?.words ?? payload;
      if (data.length > BYTES_MAX) throw new SealError('too long');
      const { v, from, m } = JSON.parse(data.toString()) as { v: number; from: string; m: Message };
      if (v !== WIRE_VERSION) throw new SealError('another wire version');
      if (letter && letter.sender !== from) throw new SealError('somebody else has written it');
      const kind = letter?.kind ?? this.#seals.examine(seal, from, place, payload);
      this.#judge(from, kind, m);
    });

  #judge(from: string, kind: string, message: Message): void {
    if (this.#shutOut.includes(from)) throw new SealError('an agent that is shut out');
    const name = SIGNED_AS[message.type];
    if (name !== undefined && (message as unknown as Record<string, unknown>)[name] !== from)
      throw new SealError("another agent's name");
    if (!SPEAKERS[message.type]?.includes(kind)) throw new SealError('a word that is not for us, or not of its kind');
    if (message.type === 'ShutOut') {
      if (message.number <= this.#shutOutNumber) return;
      this.#shutOutNumber = message.number;
      this.#shutOut = message.agents;
      return;
    }
    this.#receive(from, message);
  }

  /** Somebody is there: now letters to it can be written. A later life of ourselves takes our place. */
  #see(key: string): void {
    const [agent, life, chunk] = key.split('/').slice(-3) as [string, string, string];
    this.#seals.examineToken(key.slice(0, key.lastIndexOf('/')), agent, Number(life), chunk);
    if (agent !== this.#agent) return;
    const other = Number(life);
    if (other > this.#life || (other === this.#life && chunk > this.#token)) this.#replaced();
  }

  #guard(act: () => void): void {
    try {
      act();
    } catch (error) {
      // Whatever comes in can be anything: it is counted, and ends nothing.
      this.#count(error instanceof SealError ? error.message : 'no message of ours');
    }
  }

  #count(reason: string): void {
    this.refused.set(reason, (this.refused.get(reason) ?? 0) + 1);
  }
}
