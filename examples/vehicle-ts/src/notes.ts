/** What a vehicle's next life must know, in one file that is replaced as a whole before anything of it is said. */

import { closeSync, existsSync, fsyncSync, openSync, readFileSync, renameSync, writeSync } from 'node:fs';

import type { Phase, Transport } from './messages.ts';

export interface Contract {
  readonly task: string;
  readonly epoch: number;
  readonly work: Transport;
  readonly coordinator: string;
  readonly source: string;
  readonly promised_s: number;
  /** Of the award that binds it. */
  readonly number: number;
  readonly phase: Phase;
  /** Why it is over but for the load, which is on its way back; empty while it lasts. */
  readonly cancelled: string;
}

export interface Command {
  readonly person: string;
  readonly command: string;
  readonly refused: string;
}

interface Kept {
  life: number;
  contract: Contract | null;
  acknowledged: boolean;
  speed_frac: number;
  commands: readonly Command[];
}

export class Notes {
  readonly kept: Kept;
  #file: string;

  /** Read the file, and count this life: the number is kept before anybody hears it. */
  constructor(file: string) {
    this.#file = file;
    const nothing: Kept = { life: 0, contract: null, acknowledged: false, speed_frac: 1, commands: [] };
    this.kept = existsSync(file) ? { ...nothing, ...(JSON.parse(readFileSync(file, 'utf8')) as Kept) } : nothing;
    this.write({ life: this.kept.life + 1 });
  }

  write(changes: Partial<Kept>): void {
    Object.assign(this.kept, changes);
    const next = `${this.#file}.next`;
    const handle = openSync(next, 'w', 0o600);
    writeSync(handle, JSON.stringify(this.kept));
    fsyncSync(handle);
    closeSync(handle);
    renameSync(next, this.#file);
  }
}
