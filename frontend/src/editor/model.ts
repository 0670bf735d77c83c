/** A draft of a plant as it is drawn: pure changes of its content. Every change makes a new one, so that it can be undone. */

export interface Spot {
  readonly x_m: number;
  readonly y_m: number;
}
export interface Node extends Spot {
  readonly id: string;
}
export interface Lane {
  readonly start: string;
  readonly end: string;
  readonly speed_limit_mps?: number;
  readonly both_ways?: boolean;
  readonly two_lanes?: boolean | null;
  readonly shape?: readonly Spot[];
}
export interface Box extends Spot {
  readonly width_m: number;
  readonly depth_m: number;
}
export interface Place {
  readonly id: string;
  readonly node: string | null;
  readonly name?: string;
  readonly box?: Box | null;
  readonly kind?: string | null;
  readonly original?: string | null;
}
export interface Area {
  readonly id: string;
  readonly name: string;
  readonly polygon: readonly Spot[];
}
export interface Door {
  readonly id: string;
  readonly name: string;
  readonly lanes: readonly Pick<Lane, "start" | "end">[];
  readonly opening_s: number;
}
export interface Plan extends Spot {
  readonly width_m: number;
  readonly opacity: number;
}

/** Of any shape: what is wrong in it is said by the checks, and left out of the picture. */
export type Data = Readonly<Record<string, unknown>>;

export const PLACES = ["machines", "storages", "warehouses", "chargers", "parkings", "unassigned"] as const;
export type PlaceSection = (typeof PLACES)[number];

/** Sections that are lists of things with no place on the floor. */
export const LISTS = ["materials", "products", "stations", "vehicle_types", "fleet"] as const;

/** These, and those that are drawn. */
export const SECTIONS = [
  ...LISTS, ...PLACES, "areas", "nodes", "lanes", "doors",
] as const;

export interface Chosen {
  readonly section: "nodes" | "lanes" | "areas" | "doors" | PlaceSection;
  readonly index: number;
}

const LETTERS: Record<PlaceSection, string> = {
  machines: "M", storages: "S", warehouses: "W", chargers: "CH", parkings: "P", unassigned: "U",
};

/** The entries of a section that are objects; none of one that is open. */
// eslint-disable-next-line @typescript-eslint/no-unnecessary-type-parameters -- the caller knows what a section holds
export function entries<T>(data: Data, section: string): readonly T[] {
  const value = data[section];
  return Array.isArray(value) ? (value as T[]) : [];
}

export const nodesOf = (data: Data): readonly Node[] => entries<Node>(data, "nodes").filter(isNode);
export const lanesOf = (data: Data): readonly Lane[] => entries<Lane>(data, "lanes");

function isNode(node: unknown): node is Node {
  const one = node as Node | null;
  return typeof one?.id === "string" && Number.isFinite(one.x_m) && Number.isFinite(one.y_m);
}

export function places(data: Data): { section: PlaceSection; index: number; place: Place }[] {
  return PLACES.flatMap((section) =>
    entries<Place | null>(data, section).flatMap((place, index) => (place && typeof place.id === "string" ? [{ section, index, place }] : [])),
  );
}

export function nodeById(data: Data): Map<string, Node> {
  return new Map(nodesOf(data).map((node) => [node.id, node]));
}

/** The next free id that begins so. */
export function freeId(data: Data, begins: string, section: "nodes" | "areas" | "doors" | "places"): string {
  const taken = new Set(
    section === "places"
      ? [...places(data).map(({ place }) => place.id), ...entries<{ id: string }>(data, "fleet").map(({ id }) => id)]
      : entries<{ id: string } | null>(data, section).map((each) => each?.id),
  );
  for (let number = 1; ; number += 1) if (!taken.has(`${begins}${number}`)) return `${begins}${number}`;
}

export const snapped = (value_m: number, grid_m: number): number => Math.round(Math.round(value_m / grid_m) * grid_m * 1000) / 1000;

export function nearestNode(data: Data, spot: Spot, within_m: number): Node | null {
  let best: Node | null = null;
  let best_m = within_m;
  for (const node of nodesOf(data)) {
    const away_m = Math.hypot(node.x_m - spot.x_m, node.y_m - spot.y_m);
    if (away_m <= best_m) [best, best_m] = [node, away_m];
  }
  return best;
}

/** The index of the lane that runs nearest to a spot, along its shape; -1 when none is so near. */
export function nearestLane(data: Data, spot: Spot, within_m: number): number {
  const nodes = nodeById(data);
  let best = -1;
  let best_m = within_m;
  lanesOf(data).forEach((lane, index) => {
    const [a, b] = [nodes.get(lane.start), nodes.get(lane.end)];
    if (!a || !b) return;
    const corners = [a, ...(lane.shape ?? []), b];
    corners.slice(1).forEach((to, at) => {
      const away_m = awayFrom(spot, corners[at] ?? a, to);
      if (away_m < best_m) [best, best_m] = [index, away_m];
    });
  });
  return best;
}

/** How far a spot is from the straight line between two others. */
function awayFrom(spot: Spot, a: Spot, b: Spot): number {
  const [dx_m, dy_m] = [b.x_m - a.x_m, b.y_m - a.y_m];
  const square = dx_m * dx_m + dy_m * dy_m;
  const along = square === 0 ? 0 : ((spot.x_m - a.x_m) * dx_m + (spot.y_m - a.y_m) * dy_m) / square;
  const frac = Math.min(Math.max(along, 0), 1);
  return Math.hypot(a.x_m + frac * dx_m - spot.x_m, a.y_m + frac * dy_m - spot.y_m);
}

const put = (data: Data, section: string, value: unknown): Data => ({ ...data, [section]: value });
const added = (data: Data, section: string, entry: unknown): Data => put(data, section, [...entries(data, section), entry]);

/** The node at a spot; a new one where there is none. */
export function withNode(data: Data, spot: Spot, within_m: number): [Data, string] {
  const known = nearestNode(data, spot, within_m);
  if (known) return [data, known.id];
  const id = freeId(data, "n", "nodes");
  return [added(data, "nodes", { id, ...spot }), id];
}

const SECTIONS_OPEN = ["materials", "products", "warehouses", "storages", "chargers", "stations", "machines", "vehicle_types", "fleet"];

/** A plant file of a floor with nothing on it: its sections are open, as those of a layout of other makers. */
export function emptyFloor(name: string, width_m: number, height_m: number): string {
  const plant = name.toLowerCase().replace(/[^a-z0-9]+/g, "-").replace(/^[^a-z]+/, "").slice(0, 32).replace(/-$/, "") || "plant";
  const open = SECTIONS_OPEN.map((section) => `${section}: null\n`).join("");
  return `plant: ${plant}\nname: ${JSON.stringify(name)}\nwidth_m: ${String(width_m)}\nheight_m: ${String(height_m)}\nnodes: []\nlanes: []\n${open}`;
}

export function withLane(data: Data, start: string, end: string, bothWays: boolean): Data {
  const there = lanesOf(data).some(
    (lane) => (lane.start === start && lane.end === end) || (lane.start === end && lane.end === start && (lane.both_ways === true || bothWays)),
  );
  if (start === end || there) return data;
  return added(data, "lanes", { start, end, speed_limit_mps: 1.5, both_ways: bothWays });
}

const BOX = { width_m: 2, depth_m: 1.5 };
/** From a dock to the middle of its box. */
const AWAY_M = 1.5;

/** Where the box of a new dock stands: above it, else below, or beside it, inside the floor; of a dock outside of it, as near as can be. */
export function boxBeside(data: Data, { x_m, y_m }: Spot): Box {
  const [width_m, height_m] = [Number(data.width_m) || Infinity, Number(data.height_m) || Infinity];
  const spots = [[0, AWAY_M], [0, -AWAY_M], [AWAY_M, 0], [-AWAY_M, 0]].map(([dx = 0, dy = 0]) => ({ x_m: x_m + dx, y_m: y_m + dy }));
  const inside = (at_m: number, size_m: number, wide_m: number): number => Math.max(size_m / 2, Math.min(at_m, wide_m - size_m / 2));
  const within = (spot: Spot): Spot => ({ x_m: inside(spot.x_m, BOX.width_m, width_m), y_m: inside(spot.y_m, BOX.depth_m, height_m) });
  const fits = (spot: Spot): boolean => within(spot).y_m === spot.y_m && Math.abs(within(spot).x_m - spot.x_m) <= BOX.width_m / 2;
  return { ...within(spots.find(fits) ?? { x_m, y_m }), ...BOX };
}

/** A place that docks at a node; what nobody has said of it is null, and open. */
export function withPlace(data: Data, section: PlaceSection, spot: Spot, within_m: number): Data {
  const [next, node] = withNode(data, spot, within_m);
  const id = freeId(next, LETTERS[section], "places");
  const box = boxBeside(next, spot);
  const known = entries<{ id: string }>(next, "stations")[0]?.id ?? null;
  const made: Record<PlaceSection, object> = {
    machines: { id, name: id, station: known, node, box, makes: null },
    storages: { id, name: id, node, box, stocks: null },
    warehouses: { id, name: id, kind: null, node, box },
    chargers: { id, node, box },
    parkings: { id, node },
    unassigned: { id, name: id, node },
  };
  return added(next, section, made[section]);
}

/** What a station is: it goes to the section of that, where the rest of it is open. */
export function assigned(data: Data, index: number, to: PlaceSection): Data {
  const station = entries<Place>(data, "unassigned")[index];
  if (!station) return data;
  const spot = nodeById(data).get(station.node ?? "") ?? { x_m: 0, y_m: 0 };
  const box = station.box ?? boxBeside(data, spot);
  const { id, node } = station;
  const name = station.name ?? id;
  // What vehicles call it stays, whatever it is.
  const called = station.original === undefined ? {} : { original: station.original };
  const made: Partial<Record<PlaceSection, object>> = {
    machines: { id, name, station: entries<{ id: string }>(data, "stations")[0]?.id ?? null, node, box, makes: null, ...called },
    storages: { id, name, node, box, stocks: null, ...called },
    warehouses: { id, name, kind: null, node, box, ...called },
    chargers: { id, node, box, ...called },
    parkings: { id, node, ...called },
  };
  const rest = put(data, "unassigned", entries(data, "unassigned").filter((_, at) => at !== index));
  return added(rest, to, made[to] ?? station);
}

export function withArea(data: Data, polygon: readonly Spot[]): Data {
  if (polygon.length < 3) return data;
  const id = freeId(data, "area", "areas");
  return added(data, "areas", { id, name: id, polygon });
}

export const same = (lane: Lane, other: Lane): boolean => lane.start === other.start && lane.end === other.end;

export const isClosed = (data: Data, lane: Lane): boolean => entries<Lane>(data, "closed").some((each) => same(each, lane));

/** Close a lane in the draft, or open it again. */
export function closedOrNot(data: Data, index: number): Data {
  const lane = lanesOf(data)[index];
  if (!lane) return data;
  const closed = entries<Lane>(data, "closed");
  return put(data, "closed", isClosed(data, lane) ? closed.filter((each) => !same(each, lane)) : [...closed, { start: lane.start, end: lane.end }]);
}

type Ends = Door["lanes"][number];

/** What a door says of its lanes; null where that is no list. */
function lanesOfDoor(door: unknown): Door["lanes"] | null {
  const lanes = (door as { lanes?: unknown } | null)?.lanes;
  return Array.isArray(lanes) ? (lanes as Door["lanes"]) : null;
}

/** The doors, each with other lanes; one that has no list of them stays as it is. */
function withDoorLanes(data: Data, change: (lanes: Door["lanes"]) => Door["lanes"]): readonly Door[] {
  return entries<Door>(data, "doors").map((door) => {
    const lanes = lanesOfDoor(door);
    return lanes === null ? door : { ...door, lanes: change(lanes) };
  });
}

function joins(lane: Lane, ends: Ends | null): boolean {
  return ends !== null && (same(lane, ends) || same(lane, { start: ends.end, end: ends.start }));
}

/** The index of the door that stands on a lane; -1 where none does. */
export const doorAt = (data: Data, lane: Lane): number => entries(data, "doors").findIndex((door) => lanesOfDoor(door)?.some((each) => joins(lane, each)));

/** Whether a door stands on a lane. */
export const hasDoor = (data: Data, lane: Lane): boolean => doorAt(data, lane) >= 0;

/** Put a door on a lane, or take it away. */
export function doorOrNot(data: Data, index: number): Data {
  const lane = lanesOf(data)[index];
  if (!lane) return data;
  if (hasDoor(data, lane)) return withoutDoors(data, (each) => joins(lane, each));
  const id = freeId(data, "D", "doors");
  return added(data, "doors", { id, name: id, lanes: [{ start: lane.start, end: lane.end }], opening_s: 8, closes_after_s: 5 });
}

/** Without doors on some lanes; a door that stands on no other goes. */
function withoutDoors(data: Data, isGone: (lane: Ends) => boolean): Data {
  const left = withDoorLanes(data, (lanes) => lanes.filter((lane) => !isGone(lane)));
  return put(data, "doors", left.filter((door) => lanesOfDoor(door)?.length !== 0));
}

export function changed(data: Data, { section, index }: Chosen, fields: object): Data {
  const list = entries<object>(data, section);
  const before = list[index] as { id?: string } | undefined;
  if (!before) return data;
  let next = put(data, section, list.map((entry, at) => (at === index ? { ...entry, ...fields } : entry)));
  const id = (fields as { id?: string }).id;
  // What is called otherwise is meant by all that named it.
  if (section === "nodes" && id !== undefined && before.id !== undefined) next = renamedNode(next, before.id, id);
  return next;
}

function renamedNode(data: Data, from: string, to: string): Data {
  const name = (node: unknown): unknown => (node === from ? to : node);
  let next = data;
  for (const section of ["lanes", "closed"]) {
    next = put(next, section, entries<Lane>(next, section).map((lane) => ({ ...lane, start: name(lane.start), end: name(lane.end) })));
  }
  if (Array.isArray(next.doors)) {
    const called = (node: string): string => (node === from ? to : node);
    next = put(next, "doors", withDoorLanes(next, (lanes) => lanes.map((each) => ((each as Ends | null) ? { start: called(each.start), end: called(each.end) } : each))));
  }
  for (const section of [...PLACES, "fleet"]) {
    if (Array.isArray(next[section])) next = put(next, section, entries<Place>(next, section).map((place) => ({ ...place, node: name(place.node) })));
  }
  return next;
}

/** Move a node; docks take their boxes along. */
export function moved(data: Data, chosen: Chosen, to: Spot): Data {
  if (chosen.section === "nodes") {
    const node = entries<Node>(data, "nodes")[chosen.index];
    if (!node) return data;
    const [dx_m, dy_m] = [to.x_m - node.x_m, to.y_m - node.y_m];
    let next = changed(data, chosen, to);
    for (const { section, index, place } of places(data)) {
      if (place.node === node.id && place.box) next = changed(next, { section, index }, { box: { ...place.box, x_m: place.box.x_m + dx_m, y_m: place.box.y_m + dy_m } });
    }
    return next;
  }
  const place = entries<Place>(data, chosen.section)[chosen.index];
  return place?.box ? changed(data, chosen, { box: { ...place.box, ...to } }) : data;
}

/** Without something; a node goes with its lanes. What stood at it stands nowhere, which the checks say. */
export function removed(data: Data, { section, index }: Chosen): Data {
  const gone = entries<{ id?: string }>(data, section)[index];
  let next = put(data, section, entries(data, section).filter((_, at) => at !== index));
  if (section === "nodes") next = put(next, "lanes", lanesOf(next).filter((lane) => lane.start !== gone?.id && lane.end !== gone?.id));
  const lanes = lanesOf(next);
  if (Array.isArray(next.doors) && section !== "doors") {
    next = withoutDoors(next, (each) => !lanes.some((lane) => joins(lane, each)));
  }
  return Array.isArray(next.closed) ? put(next, "closed", entries<Lane>(next, "closed").filter((each) => lanes.some((lane) => same(lane, each)))) : next;
}

/** A change that solves an error, as the gateway proposes it. */
export interface Repair {
  readonly section: string;
  readonly index: number | null;
  readonly entry: object | null;
  /** Entries of the same section that change with it. */
  readonly also: readonly { readonly index: number; readonly entry: object }[];
}

/** With a repair: an entry more, one less, or one with other fields. */
export function repaired(data: Data, { section, index, entry, also }: Repair): Data {
  if (entry === null) return index === null ? data : removed(data, { section: section as Chosen["section"], index });
  if (index === null) return added(data, section, entry);
  return [{ index, entry }, ...also].reduce((next, each) => changed(next, { section: section as Chosen["section"], index: each.index }, each.entry), data);
}

/** What a finding is about: `machines[3].node` is machine 3. */
export function chosenOf(field: string): Chosen | null {
  const found = /^(\w+)\[(\d+)\]/.exec(field);
  const section = found?.[1] ?? "";
  const drawn = ["nodes", "lanes", "areas", "doors", ...PLACES] as const;
  const known = drawn.find((each) => each === section);
  return known && found ? { section: known, index: Number(found[2]) } : null;
}

export function spotOf(data: Data, chosen: Chosen): Spot | null {
  const nodes = nodeById(data);
  const entry = entries<object>(data, chosen.section)[chosen.index];
  if (!entry) return null;
  if (chosen.section === "nodes") return entry as Node;
  if (chosen.section === "areas") return (entry as Area).polygon[0] ?? null;
  if (chosen.section === "lanes" || chosen.section === "doors") {
    const lane = chosen.section === "lanes" ? (entry as Lane) : lanesOfDoor(entry)?.[0];
    const [a, b] = [nodes.get(lane?.start ?? ""), nodes.get(lane?.end ?? "")];
    return a && b ? { x_m: (a.x_m + b.x_m) / 2, y_m: (a.y_m + b.y_m) / 2 } : null;
  }
  const place = entry as Place;
  return place.box ?? nodes.get(place.node ?? "") ?? null;
}

/** How many entries differ from those of the running plant. */
export function differences(data: Data, running: Data): number {
  let count = 0;
  for (const section of SECTIONS) {
    const [ours, theirs] = [entries<object>(data, section), entries<object>(running, section)].map((list) => new Set(list.map((each) => JSON.stringify(each))));
    for (const each of ours ?? []) if (!theirs?.has(each)) count += 1;
    const key = (each: string): string => {
      const { id, start, end } = JSON.parse(each) as { id?: string; start?: string; end?: string };
      return id ?? `${start} ${end}`;
    };
    const kept = new Set([...(ours ?? [])].map(key));
    for (const each of theirs ?? []) if (!kept.has(key(each))) count += 1;
  }
  return count + entries(data, "closed").length;
}
