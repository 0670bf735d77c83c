/** What a transport costs this vehicle, in seconds, and whether it can keep what it would promise. */

import type { Driver } from './driver.ts';
import type { Transport, TransportCost } from './messages.ts';
import type { Plant } from './plant.ts';

const ENERGY_S_PER_WH = 2;
const LOW_BATTERY_S = 60;
const SPARE_ABILITY_S = 10;
const RESERVE_FRAC = 0.1;
/** Our own lengths of time are estimates: a promise has room. */
const ROOM = 1.1;
const ROOM_S = 5;

export interface Quote {
  readonly source: string;
  readonly cost: TransportCost;
  readonly finish_s: number;
}

/** The cheapest offer that can be kept, or nothing. */
export function quote(
  plant: Plant,
  driver: Driver,
  battery_frac: number,
  work: Transport,
  now_s: number,
  deadline_s: number,
): Quote | undefined {
  const type = driver.type;
  if (!type.abilities.includes(work.ability)) return undefined;
  const there = plant.dockOf(work.destination) ?? work.node;
  const offers: Quote[] = [];
  for (const source of work.sources) {
    const dock = plant.dockOf(source) ?? work.node;
    const empty = dock ? driver.wayTo(dock) : undefined;
    const loaded = dock && there ? driver.way(dock, there) : undefined;
    if (!empty || !loaded) continue;
    const empty_way_s = driver.next_s + empty.duration_s;
    const took_s = empty_way_s + type.load_s + loaded.duration_s + type.unload_s;
    const used_wh =
      empty.length_m * type.drive_wh_per_m + loaded.length_m * type.loaded_wh_per_m + (took_s * type.idle_w) / 3600;
    const left_frac = battery_frac - used_wh / type.battery_wh;
    const missing = Math.max(0, 0.5 - left_frac) / 0.5;
    const cost: TransportCost = {
      kind: 'transport',
      empty_way_s,
      loaded_way_s: loaded.duration_s,
      energy_s: used_wh * ENERGY_S_PER_WH + LOW_BATTERY_S * missing * missing,
      suitability_s: SPARE_ABILITY_S * (type.abilities.length - 1),
    };
    const finish_s = now_s + took_s * ROOM + ROOM_S;
    const needed_frac = RESERVE_FRAC + chargerWh(plant, driver, there!) / type.battery_wh;
    if (left_frac >= needed_frac && finish_s <= deadline_s) offers.push({ source, cost, finish_s });
  }
  return offers.sort((a, b) => total(a.cost) - total(b.cost))[0];
}

/** Energy from a node to the nearest charger. */
function chargerWh(plant: Plant, driver: Driver, node: string): number {
  const ways = plant.chargers.map((charger) => driver.way(node, plant.dockOf(charger)!)?.length_m ?? Infinity);
  return Math.min(...ways) * driver.type.drive_wh_per_m;
}

function total({ empty_way_s, loaded_way_s, energy_s, suitability_s }: TransportCost): number {
  return empty_way_s + loaded_way_s + energy_s + suitability_s;
}
