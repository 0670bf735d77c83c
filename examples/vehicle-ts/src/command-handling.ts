/** People's commands: obeyed with a grant for the place where the vehicle is, and with none else (docs/protocol.md, "Grants"). */

import { createPublicKey, verify, type KeyObject } from 'node:crypto';

import type { Body } from './body.ts';
import type { Grant, VehicleCommand } from './messages.ts';
import type { Notes } from './notes.ts';
import type { Plant } from './plant.ts';

const COMMANDS_KEPT = 32;
/** Before the 32 bytes of an Ed25519 public key, in DER. */
const ED25519 = Buffer.from('302a300506032b6570032100', 'hex');

export class CommandHandling {
  stopped: boolean;
  #atv: string;
  #plant: Plant;
  #body: Body;
  #notes: Notes;
  #trusted: KeyObject[];

  constructor(atv: string, plant: Plant, body: Body, notes: Notes, trusted: readonly string[]) {
    this.#atv = atv;
    this.#plant = plant;
    this.#body = body;
    this.#notes = notes;
    this.#trusted = trusted.map((hex) =>
      createPublicKey({ key: Buffer.concat([ED25519, Buffer.from(hex, 'hex')]), format: 'der', type: 'spki' }),
    );
    this.stopped = body.state.held;
    notes.kept.acknowledged &&= this.stopped && !body.state.problem;
  }

  get acknowledged(): boolean {
    return this.#notes.kept.acknowledged;
  }

  /** Carry it out or refuse it; the reason of the refusal, empty when it was not. One that comes again is answered as before. */
  onCommand(command: VehicleCommand, now_s: number): string {
    const grant = command.grant;
    if (!grant) return 'not_granted';
    const words = signedWords(this.#atv, command, grant);
    const signature = Buffer.from(grant.signature, 'base64');
    if (!this.#trusted.some((key) => verify(null, words, key, signature)))
      return 'not_trusted';
    const { commands } = this.#notes.kept;
    const before = commands.find(({ person, command: name }) => person === grant.person && name === command.command);
    if (before) return before.refused;
    if (now_s > grant.valid_until_s) return 'expired';
    const here = this.#body.state.pose;
    const covered = grant.everywhere || this.#plant.isIn(grant.areas ?? [], here, command.kind === 'stop');
    const refused = covered ? this.#try(command) : 'not_here';
    const noted = { person: grant.person, command: command.command, refused };
    this.#notes.write({ commands: [...commands, noted].slice(-COMMANDS_KEPT) });
    return refused;
  }

  /** A fault has come up that no acknowledge can have meant. */
  takeBack(): void {
    if (this.acknowledged) this.#notes.write({ acknowledged: false });
  }

  #try(command: VehicleCommand): string {
    if (command.kind === 'stop') {
      this.stopped = true;
      this.#notes.write({ acknowledged: false });
      this.#body.instruct({ kind: 'Hold' });
      return '';
    }
    if (command.kind === 'set_speed') {
      const speed_frac = command.speed_frac ?? 0;
      if (!(speed_frac > 0 && speed_frac <= 1)) return 'speed_out_of_range';
      this.#notes.write({ speed_frac });
      this.#body.instruct({ kind: 'LimitSpeed', speed_frac });
      return '';
    }
    if (command.kind === 'promise' || command.kind === 'hand_over') return 'not_waiting';
    if (command.kind === 'charge' || command.kind === 'take_out' || command.kind === 'put_in') return 'not_supported';
    if (!this.stopped) return 'not_stopped';
    if (command.kind === 'acknowledge') {
      if (this.#body.state.problem) return 'faulty';
      this.#notes.write({ acknowledged: true });
      return '';
    }
    if (!this.acknowledged) return 'not_acknowledged';
    this.stopped = false;
    this.#notes.write({ acknowledged: false });
    this.#body.instruct({ kind: 'Unhold' });
    return '';
  }
}

/** What a grant's signature covers: numbers in whole thousandths. */
export function signedWords(atv: string, command: VehicleCommand, grant: Grant): Buffer {
  const thousandths = (value: number | null | undefined) => (value == null ? null : Math.floor(value * 1000 + 0.5));
  return Buffer.from(
    JSON.stringify([
      'dray command 2',
      atv,
      command.command,
      command.kind,
      thousandths(command.speed_frac),
      thousandths(command.wait_s),
      command.issued_by ?? '',
      grant.person,
      grant.areas ?? [],
      grant.everywhere ?? false,
      thousandths(grant.valid_until_s),
    ]),
  );
}
