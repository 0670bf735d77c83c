/** The plant, as `dray plant json` writes it: places, cells of announcements, and ways over the lanes. */

interface Place {
  readonly id: string;
  readonly node: string;
}

export interface VehicleType {
  readonly id: string;
  readonly max_speed_mps: number;
  readonly acceleration_mps2: number;
  readonly turn_speed_mps: number;
  readonly abilities: readonly string[];
  readonly load_s: number;
  readonly unload_s: number;
  readonly battery_wh: number;
  readonly drive_wh_per_m: number;
  readonly loaded_wh_per_m: number;
  readonly idle_w: number;
}

/** A type of vehicle that may drive on a lane; its limit is null where that of the lane holds. */
interface LaneType {
  readonly type: string;
  readonly speed_limit_mps?: number | null;
}

interface PlantFile {
  readonly plant: string;
  readonly width_m: number;
  readonly height_m: number;
  readonly cell_m: number;
  readonly nodes: readonly { readonly id: string; readonly x_m: number; readonly y_m: number }[];
  readonly lanes: readonly {
    readonly start: string;
    readonly end: string;
    readonly speed_limit_mps: number;
    readonly both_ways: boolean;
    readonly types: readonly LaneType[];
  }[];
  readonly warehouses: readonly (Place & { readonly kind: 'source' | 'delivery' })[];
  readonly storages: readonly (Place & { readonly stocks: readonly { readonly material: string }[] })[];
  readonly chargers: readonly Place[];
  readonly parkings: readonly Place[];
  readonly machines: readonly Place[];
  readonly vehicle_types: readonly VehicleType[];
  readonly fleet: readonly { readonly id: string; readonly type: string; readonly node: string }[];
  readonly areas: readonly { readonly id: string; readonly polygon: readonly Point[] }[];
}

export interface Point {
  readonly x_m: number;
  readonly y_m: number;
}

export interface Way {
  /** The first is where it begins. */
  readonly nodes: readonly string[];
  readonly length_m: number;
  readonly duration_s: number;
}

interface Lane {
  readonly end: string;
  readonly types: readonly LaneType[];
  readonly length_m: number;
  readonly speed_mps: number;
  readonly heading_rad: number;
}

const BEND_RAD = Math.PI / 6;
const STOP_MARGIN_M = 2;

export class Plant {
  readonly id: string;
  readonly chargers: readonly string[];
  readonly parkings: readonly string[];
  #file: PlantFile;
  #nodes = new Map<string, Point>();
  #dockOf = new Map<string, string>();
  #lanes = new Map<string, Lane[]>();

  constructor(json: string) {
    this.#file = JSON.parse(json) as PlantFile;
    const { nodes, lanes, warehouses, storages, chargers, parkings, machines } = this.#file;
    this.id = this.#file.plant;
    this.chargers = chargers.map(({ id }) => id);
    this.parkings = parkings.map(({ id }) => id);
    for (const node of nodes) this.#nodes.set(node.id, node);
    for (const { id, node } of [...warehouses, ...storages, ...chargers, ...parkings, ...machines])
      this.#dockOf.set(id, node);
    for (const lane of lanes) {
      this.#addLane(lane.start, lane.end, lane);
      if (lane.both_ways) this.#addLane(lane.end, lane.start, lane);
    }
  }

  typeOf(vehicle: string, type?: string): VehicleType {
    const wanted = type ?? this.#file.fleet.find(({ id }) => id === vehicle)?.type;
    const found = this.#file.vehicle_types.find(({ id }) => id === wanted);
    if (!found) throw new Error(`${vehicle}: the plant has no vehicle type ${wanted ?? 'for it'}`);
    return found;
  }

  point(node: string): Point {
    const found = this.#nodes.get(node);
    if (!found) throw new Error(`the plant has no node ${node}`);
    return found;
  }

  /** The node where vehicles dock; nothing when nobody knows the place. */
  dockOf(place: string): string | undefined {
    return this.#dockOf.get(place);
  }

  isDelivery(place: string): boolean {
    return this.#file.warehouses.some(({ id, kind }) => id === place && kind === 'delivery');
  }

  /** Where a load that nobody waits for can go: a material to its storages, a product to the delivery warehouses. */
  refugesOf(item: string): string[] {
    const storages = this.#file.storages.filter(({ stocks }) => stocks.some(({ material }) => material === item));
    return (storages.length ? storages : this.#file.warehouses.filter(({ kind }) => kind === 'delivery')).map(({ id }) => id);
  }

  /** The cell whose announcements concern a point: `COLUMN_ROW`, both from 0. */
  cellOf({ x_m, y_m }: Point): string {
    const { width_m, height_m, cell_m } = this.#file;
    const clip = (value: number, extent: number) =>
      Math.trunc(Math.min(Math.max(value / cell_m, 0), Math.max(1, Math.ceil(extent / cell_m)) - 1));
    return `${clip(x_m, width_m)}_${clip(y_m, height_m)}`;
  }

  /** Whether a point is in one of these areas, or a stop's 2 m beside it. */
  isIn(areas: readonly string[], point: Point, isStop: boolean): boolean {
    const wanted = this.#file.areas.filter(({ id }) => areas.includes(id));
    return wanted.some(({ polygon }) => isWithin(polygon, point, isStop ? STOP_MARGIN_M : 0));
  }

  /** The quickest way; nothing when none leads there. */
  way(start: string, goal: string, type: VehicleType): Way | undefined {
    const best = new Map([[start, 0]]);
    const before = new Map<string, string>();
    const open = new Set([start]);
    const done = new Set<string>();
    while (open.size) {
      const here = [...open].reduce((a, b) => (best.get(b)! < best.get(a)! ? b : a));
      if (here === goal) break;
      open.delete(here);
      done.add(here);
      for (const lane of this.#lanes.get(here) ?? []) {
        const allowed = lane.types.find((each) => each.type === type.id);
        if (lane.types.length && !allowed) continue;
        const limit_mps = Math.min(lane.speed_mps, allowed?.speed_limit_mps ?? Infinity, type.max_speed_mps);
        const there = best.get(here)! + lane.length_m / limit_mps;
        if (done.has(lane.end) || there >= (best.get(lane.end) ?? Infinity)) continue;
        best.set(lane.end, there);
        before.set(lane.end, here);
        open.add(lane.end);
      }
    }
    if (!best.has(goal)) return undefined;
    const nodes = [goal];
    while (nodes[0] !== start) nodes.unshift(before.get(nodes[0]!)!);
    return this.#measured(nodes, best.get(goal)!, type);
  }

  /** Lane times, and what starting, braking and turning cost beside them: `(v - u)^2 / (a v)` for a slow-down to u. */
  #measured(nodes: readonly string[], lanes_s: number, type: VehicleType): Way {
    const lanes = nodes.slice(1).map((end, place) => this.#lanes.get(nodes[place]!)!.find((lane) => lane.end === end)!);
    const { max_speed_mps: v, acceleration_mps2: a, turn_speed_mps: u } = type;
    const bends = lanes.slice(1).filter((lane, place) => bend(lanes[place]!.heading_rad, lane.heading_rad) > BEND_RAD);
    const slow_s = (bends.length * (v - Math.min(u, v)) ** 2) / (a * v) + (lanes.length ? v / a : 0);
    const length_m = lanes.reduce((sum, lane) => sum + lane.length_m, 0);
    return { nodes, length_m, duration_s: lanes_s + slow_s };
  }

  #addLane(start: string, end: string, of: PlantFile['lanes'][number]): void {
    const [from, to] = [this.point(start), this.point(end)];
    const [dx, dy] = [to.x_m - from.x_m, to.y_m - from.y_m];
    const lane = { end, length_m: Math.hypot(dx, dy), speed_mps: of.speed_limit_mps, types: of.types, heading_rad: Math.atan2(dy, dx) };
    this.#lanes.set(start, [...(this.#lanes.get(start) ?? []), lane]);
  }
}

function bend(before: number, after: number): number {
  const turn = Math.abs(after - before) % (2 * Math.PI);
  return Math.min(turn, 2 * Math.PI - turn);
}

function isWithin(polygon: readonly Point[], { x_m, y_m }: Point, margin_m: number): boolean {
  let inside = false;
  for (const [place, a] of polygon.entries()) {
    const b = polygon[(place + 1) % polygon.length]!;
    const [dx, dy] = [b.x_m - a.x_m, b.y_m - a.y_m];
    const along = Math.min(Math.max(((x_m - a.x_m) * dx + (y_m - a.y_m) * dy) / (dx * dx + dy * dy || 1), 0), 1);
    if (Math.hypot(x_m - a.x_m - along * dx, y_m - a.y_m - along * dy) <= margin_m) return true;
    if (a.y_m > y_m !== b.y_m > y_m && x_m < a.x_m + ((y_m - a.y_m) / dy) * dx) inside = !inside;
  }
  return inside;
}
