/** Runs one vehicle until a signal: SIGTERM lets it shut down gracefully, Ctrl-C ends it at once. See README.md. */

import { mkdirSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import { parseArgs } from 'node:util';

import { Body } from './body.ts';
import { Bus } from './bus.ts';
import { Driver } from './driver.ts';
import type { Message } from './messages.ts';
import { Notes } from './notes.ts';
import { CommandHandling } from './command-handling.ts';
import { Plant } from './plant.ts';
import { Seals } from './seals.ts';
import { Vehicle } from './vehicle.ts';
import { Session, type Files } from './zenoh.ts';

const TICK_MS = 50;

const { values } = parseArgs({
  options: {
    name: { type: 'string' },
    // Of a joining vehicle, which the plant file does not know: its type, and where it stands.
    type: { type: 'string' },
    node: { type: 'string' },
    plant: { type: 'string' },
    certificates: { type: 'string' },
    peers: { type: 'string' },
    notes: { type: 'string', default: 'notes' },
    'trusted-keys': { type: 'string', default: '' },
    // Of a factory with simulated bodies whose clock runs faster (DRAY_PLANT_SPEED and DRAY_PLANT_EPOCH_S).
    speed: { type: 'string', default: '1' },
    'epoch-s': { type: 'string', default: '0' },
  },
});

function needed(name: 'name' | 'plant' | 'certificates' | 'peers'): string {
  const value = values[name];
  if (value === undefined) throw new Error(`--${name} is missing; README.md tells what it is`);
  return value;
}

async function link(peers: readonly string[], files: Files): Promise<Session> {
  const failed: string[] = [];
  for (const peer of peers) {
    try {
      return await Session.open(peer, files);
    } catch (error) {
      failed.push(String(error));
    }
  }
  throw new Error(`no router can be reached: ${failed.join('; ')}`);
}

async function run(): Promise<void> {
  const name = needed('name');
  const folder = needed('certificates');
  const read = (file: string) => readFileSync(join(folder, file), 'utf8');
  const files: Files = { authority: read('authority.pem'), certificate: read(`${name}.pem`), key: read(`${name}.key`) };
  const plant = new Plant(readFileSync(needed('plant'), 'utf8'));
  const seals = new Seals(plant.id, files);
  if (seals.kinds.get(name) !== 'atv') throw new Error(`the certificate names no vehicle ${name} of ${plant.id}`);
  const [speed, epoch_s] = [Number(values.speed), Number(values['epoch-s'])];
  const now_s = () => epoch_s + (Date.now() / 1000 - epoch_s) * speed;
  const tell = (line: string) => console.log(`${name} ${line}`);

  mkdirSync(values.notes, { recursive: true });
  const notes = new Notes(join(values.notes, `${name}.json`));
  const { life } = notes.kept;
  const session = await link(needed('peers').split(','), files);
  const { type, node } = values;
  if (type !== undefined && node !== undefined) await Body.putDown(session, plant.id, { id: name, type, node });
  const body = await Body.take(session, plant.id, name, life);
  if (body.isNew && notes.kept.contract) throw new Error('the body that the notes are about is gone: move them away');

  const driver = new Driver(plant, plant.typeOf(name, type), body, life, now_s());
  const trusted = values['trusted-keys'].split(',').filter(Boolean);
  const commands = new CommandHandling(name, plant, body, notes, trusted);
  let vehicle: Vehicle | undefined;
  let end: (why: string) => void = () => undefined;
  const ended = new Promise<string>((settle) => (end = settle));
  const receive = (sender: string, message: Message) => vehicle?.onMessage(sender, message);
  const bus = new Bus(session, seals, { plant: plant.id, agent: name, life }, receive, () => end('has been started elsewhere'));
  vehicle = new Vehicle(name, { plant, driver, body, bus, notes, commands, now_s, tell });
  const present = vehicle;
  tell('is ready');

  process.once('SIGTERM', () => present.leave());
  process.once('SIGINT', () => end(''));
  const ticking = setInterval(() => {
    try {
      present.tick();
      if (present.mayGo) end('');
      else if (body.isSilent) end('its body has fallen silent');
    } catch (error) {
      end(String(error));
    }
  }, TICK_MS);
  const why = await Promise.race([ended, session.ended.then((reason) => `its link has ended: ${reason}`)]);
  clearInterval(ticking);
  for (const [reason, count] of bus.refused) tell(`refused ${count}: ${reason}`);
  if (why) throw new Error(why);
  // What was said last is still to go out.
  session.close();
  await session.ended;
}

run().then(
  () => process.exit(0),
  (error: unknown) => {
    console.error(`${values.name ?? 'vehicle'}: ${error instanceof Error ? error.message : String(error)}`);
    process.exit(1);
  },
);
