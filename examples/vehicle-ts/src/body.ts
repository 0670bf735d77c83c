/** The vehicle's body: here one on Dray's simulated floor, used over the bus (docs/agents.md, "A body on the simulated floor"). */

import { pack, unpack, type Value } from './msgpack.ts';
import { NoAnswer, type Session } from './zenoh.ts';

const ANSWER_WITHIN_MS = 3_000;
const ASK_AGAIN_MS = 250;
const ASK_FOR_MS = 30_000;
const PARTS_PER_LETTER = 50;
const SILENT_MS = 10_000;
/** Told nothing of so many instructions, the floor is gone. */
const KEPT_MAX = 1_000;

export type Instruction =
  | { readonly kind: 'Drive'; readonly order: number; readonly nodes: readonly string[]; readonly released: number }
  | {
      readonly kind: 'Pick';
      readonly order: number;
      readonly station: string;
      readonly item: string;
      readonly quantity: number;
    }
  | { readonly kind: 'Drop'; readonly order: number; readonly station: string; readonly goal: string }
  | { readonly kind: 'Charge'; readonly order: number; readonly charger: string }
  | { readonly kind: 'LimitSpeed'; readonly speed_frac: number }
  | { readonly kind: 'Hold' | 'Unhold' };

export type Report =
  | { readonly kind: 'NodePassed'; readonly order: number; readonly node: string; readonly index: number }
  | { readonly kind: 'WayDone'; readonly order: number; readonly node: string }
  | { readonly kind: 'ActionDone'; readonly order: number }
  | { readonly kind: 'ActionFailed'; readonly order: number; readonly reason: string }
  | { readonly kind: 'ProblemRaised'; readonly reason: string }
  | { readonly kind: 'ProblemCleared' }
  | { readonly kind: 'LinkNoticed'; readonly link: string };

export interface State {
  readonly pose: { readonly x_m: number; readonly y_m: number; readonly heading_rad: number };
  readonly node: string;
  readonly next_node: string;
  readonly next_node_s: number;
  readonly speed_mps: number;
  readonly battery_frac: number;
  readonly load: string;
  readonly load_quantity: number;
  readonly held: boolean;
  readonly charging: boolean;
  readonly problem: string;
}

type Part = readonly [string, Record<string, Value>];

/** What the floor answers; it may be starting too. */
async function answered(session: Session, key: string, question: Uint8Array): Promise<Buffer> {
  for (const begun = Date.now(); ; ) {
    try {
      return await session.ask(key, question, ANSWER_WITHIN_MS);
    } catch (error) {
      if (!(error instanceof NoAnswer) || Date.now() - begun > ASK_FOR_MS)
        throw new Error(`${key}: ${error instanceof Error ? error.message : String(error)}`, { cause: error });
      await new Promise((settle) => setTimeout(settle, ASK_AGAIN_MS));
    }
  }
}

export class Body {
  state: State;
  /** No life has had it before: what a journal says of a body is about another one. */
  readonly isNew: boolean;
  #session: Session;
  #key: string;
  #life: number;
  #report: (report: Report) => void = () => undefined;
  #heard = 0;
  #first = 1;
  #kept: Part[] = [];
  #heardAt = Date.now();

  private constructor(session: Session, key: string, life: number, taken: readonly Value[]) {
    this.#session = session;
    this.#key = key;
    this.#life = life;
    this.state = (taken[0] as unknown as [string, State])[1];
    this.isNew = !taken[2];
    session.subscribe(`${key}/told`, (_, payload) => this.#onMessage(payload));
  }

  /** Put a vehicle on the floor that the plant file does not know; harmless when it stands there already. */
  static async putDown(session: Session, plant: string, spec: { id: string; type: string; node: string }): Promise<void> {
    await answered(session, `${plant}/floor/@joining`, pack(['VehicleSpec', spec]));
  }

  /** Take the body over. */
  static async take(session: Session, plant: string, agent: string, life: number): Promise<Body> {
    const key = `${plant}/body/@${agent}`;
    const taken = unpack(await answered(session, key, Buffer.from(String(life)))) as readonly Value[];
    if (taken[1] !== life) throw new Error(`another life of ${agent} has its body (${String(taken[1])})`);
    return new Body(session, key, life, taken);
  }

  attach(report: (report: Report) => void): void {
    this.#report = report;
  }

  /** Nothing was heard of it for so long that nobody should believe any more that all is well. */
  get isSilent(): boolean {
    return Date.now() - this.#heardAt > SILENT_MS;
  }

  instruct({ kind, ...fields }: Instruction): void {
    if (this.#kept.length >= KEPT_MAX) throw new Error('the floor has not heard the last 1,000 instructions');
    this.#kept.push([kind, fields]);
    this.#write();
  }

  /** All that is not heard yet, and how far the floor was heard. */
  #write(): void {
    const letter: Value = [this.#heard, this.#first, this.#kept.slice(0, PARTS_PER_LETTER)];
    this.#session.put(`${this.#key}/do`, pack([this.#life, letter]));
  }

  #onMessage(payload: Buffer): void {
    const [life, letter, state] = unpack(payload) as unknown as [number, [number, number, Part[]], [string, State]];
    if (life !== this.#life) return;
    this.#heardAt = Date.now();
    this.state = state[1];
    const [heard, first, parts] = letter;
    const known = heard + 1 - this.#first;
    if (known > 0) {
      this.#kept.splice(0, known);
      this.#first += known;
    }
    const old = this.#heard + 1 - first;
    if (old >= 0) {
      const news = parts.slice(old);
      this.#heard += news.length;
      for (const [kind, fields] of news) this.#report({ kind, ...fields } as unknown as Report);
    }
    if (this.#kept.length || parts.length) this.#write();
  }
}
