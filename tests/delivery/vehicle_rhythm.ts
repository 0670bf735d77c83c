/** A vehicle on a clock of its own: it rests, works, has a problem, and rests again. Prints its heartbeats, a line of JSON each. */

import { readFileSync } from 'node:fs';
import { join } from 'node:path';

const [plantFile, notesFolder, sources] = process.argv.slice(2) as [string, string, string];
const { CommandHandling } = await import(join(sources, 'command-handling.ts'));
const { Driver } = await import(join(sources, 'driver.ts'));
const { Notes } = await import(join(sources, 'notes.ts'));
const { Plant } = await import(join(sources, 'plant.ts'));
const { Vehicle } = await import(join(sources, 'vehicle.ts'));

/** Seconds of the plant's clock between two ticks: those of a plant that is five times as fast. */
const TICK_S = 0.25;

let now_s = 1000;
let report: (told: object) => void = () => undefined;

const body = {
  state: {
    ...{ pose: { x_m: 2, y_m: 10, heading_rad: 0 }, node: 'chg', next_node: 'chg', next_node_s: 0, speed_mps: 0 },
    ...{ battery_frac: 1, load: '', load_quantity: 0, held: false, charging: false, problem: '' },
  },
  isNew: true,
  attach: (told: typeof report) => (report = told),
  // Its ways never end: what is beside the rhythm is tested with a floor.
  instruct: () => undefined,
};

const bus = {
  send: () => undefined,
  publish: (_key: string, message: { type: string }) => {
    if (message.type === 'AtvHeartbeat') console.log(JSON.stringify(message));
  },
  subscribe: () => undefined,
  unsubscribe: () => undefined,
};

const plant = new Plant(readFileSync(plantFile, 'utf8'));
const notes = new Notes(join(notesFolder, 'A1.json'));
const vehicle = new Vehicle('A1', {
  plant,
  driver: new Driver(plant, plant.typeOf('A1'), body, 1, now_s),
  body,
  bus,
  notes,
  commands: new CommandHandling('A1', plant, body, notes, []),
  now_s: () => now_s,
  tell: () => undefined,
});

function pass(for_s: number): void {
  for (const until_s = now_s + for_s; now_s < until_s; now_s += TICK_S) vehicle.tick();
}

pass(30);
const work = { kind: 'transport', item: 'plank', quantity: 6, sources: ['S1'], destination: 'M1', ability: 'tote' };
const award = { type: 'Award', task: 'M1-1', epoch: 1, role: 'primary', work, deadline_s: now_s + 600, number: 1 };
vehicle.onMessage('M1', award);
pass(30);
vehicle.onMessage('M1', { type: 'Release', task: 'M1-1', epoch: 1, role: 'primary', number: 1 });
pass(30);
report({ kind: 'ProblemRaised', reason: 'a wheel is stuck' });
pass(30);
report({ kind: 'ProblemCleared' });
pass(30);
