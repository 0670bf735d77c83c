/**
 * What the stream has told so far, as plain data, and how a frame changes it. Pure: a frame in, a new
 * world out. Who reads the socket, and when a panel redraws, is decided elsewhere.
 */
import type {
  AlertView,
  AtvView,
  AudienceView,
  ClosureView,
  CommandView,
  Delta,
  FactoryView,
  FaultView,
  MachineView,
  NewsView,
  ObstacleView,
  OrderView,
  ScenarioView,
  Snapshot,
  StationView,
  TaskView,
  WaitView,
} from "../api/types";

export type Frame = Snapshot | Delta;

export interface World {
  /** Number of the frame that this world is the result of. */
  readonly number: number;
  /** The server's clock when it sent that frame, seconds since 1970. */
  readonly atS: number;
  readonly plant: string;
  readonly factory: FactoryView;
  readonly atvs: ReadonlyMap<string, AtvView>;
  readonly machines: ReadonlyMap<string, MachineView>;
  /** Of storages, by the storage's id. */
  readonly stations: ReadonlyMap<string, StationView>;
  readonly tasks: ReadonlyMap<string, TaskView>;
  readonly orders: ReadonlyMap<string, OrderView>;
  /** What has happened lately, oldest first. */
  readonly news: ReadonlyMap<string, NewsView>;
  /** What is wrong now. */
  readonly alerts: ReadonlyMap<string, AlertView>;
  /** Whether faults can be begun by hand. */
  readonly fault_injection: boolean;
  /** Those that were begun by hand and have not ended. */
  readonly faults: ReadonlyMap<string, FaultView>;
  /** What people have asked of vehicles lately, oldest first, and what became of it. */
  readonly commands: ReadonlyMap<string, CommandView>;
  /** What people have closed to vehicles, oldest first. */
  readonly closures: ReadonlyMap<string, ClosureView>;
  /** What vehicles have met on lanes, oldest first. */
  readonly obstacles: ReadonlyMap<string, ObstacleView>;
  /** Vehicles that cannot drive on, and for whom they wait; empty where vehicles drive without right of way. */
  readonly waits: ReadonlyMap<string, WaitView>;
  /** The one that the simulated factory plays, if any. */
  readonly scenarios: ReadonlyMap<string, ScenarioView>;
  /** Who is shown all this, and how much of the plant. */
  readonly audience: AudienceView | null;
}

/** The prefix of an id in `Delta.gone`, and the collection that it leaves. */
const GONE = {
  atv: "atvs",
  machine: "machines",
  station: "stations",
  task: "tasks",
  order: "orders",
  news: "news",
  alert: "alerts",
  fault: "faults",
  command: "commands",
  closure: "closures",
  obstacle: "obstacles",
  wait: "waits",
  scenario: "scenarios",
} as const;

export function worldOf(frame: Snapshot): World {
  return {
    number: frame.number,
    atS: frame.at_s,
    plant: frame.plant,
    factory: frame.factory,
    atvs: byId(frame.atvs),
    machines: byId(frame.machines),
    stations: byId(frame.stations),
    tasks: byId(frame.tasks),
    orders: byId(frame.orders),
    news: byId(frame.news),
    alerts: byId(frame.alerts),
    fault_injection: frame.fault_injection,
    faults: byId(frame.faults),
    commands: byId(frame.commands),
    closures: byId(frame.closures),
    obstacles: byId(frame.obstacles),
    waits: byId(frame.waits),
    scenarios: byId(frame.scenarios),
    audience: frame.audience,
  };
}

/**
 * The world after a frame, or null where the frame does not follow: a number is missing, or the
 * stream began without a snapshot. Then only a fresh snapshot helps.
 */
export function advance(world: World | null, frame: Frame): World | null {
  if (frame.type === "snapshot") return worldOf(frame);
  if (world === null || frame.number !== world.number + 1) return null;
  const gone = goneByKind(frame.gone);
  return {
    ...world,
    number: frame.number,
    atS: frame.at_s,
    factory: frame.factory ?? world.factory,
    atvs: changed(world.atvs, frame.atvs, gone.atvs),
    machines: changed(world.machines, frame.machines, gone.machines),
    stations: changed(world.stations, frame.stations, gone.stations),
    tasks: changed(world.tasks, frame.tasks, gone.tasks),
    orders: changed(world.orders, frame.orders, gone.orders),
    news: changed(world.news, frame.news, gone.news),
    alerts: changed(world.alerts, frame.alerts, gone.alerts),
    faults: changed(world.faults, frame.faults, gone.faults),
    commands: changed(world.commands, frame.commands, gone.commands),
    closures: changed(world.closures, frame.closures, gone.closures),
    obstacles: changed(world.obstacles, frame.obstacles, gone.obstacles),
    waits: changed(world.waits, frame.waits, gone.waits),
    scenarios: changed(world.scenarios, frame.scenarios, gone.scenarios),
  };
}

/** What a frame tells of an entity: of a new one everything, of another one its id and what has changed. */
type Patch<T> = Partial<T> & { id: string };

/** The entities that a delta tells of, as they are after it. */
export function toldOf<T>(patches: readonly { id: string }[], after: ReadonlyMap<string, T>): T[] {
  return patches.flatMap(({ id }) => after.get(id) ?? []);
}

function byId<T extends { id: string }>(views: readonly T[]): Map<string, T> {
  return new Map(views.map((view) => [view.id, view]));
}

/** The same map when nothing changed, so that whoever compares by identity need not look again. */
function changed<T extends { id: string }>(
  before: ReadonlyMap<string, T>,
  patches: readonly Patch<T>[],
  gone: readonly string[],
): ReadonlyMap<string, T> {
  if (patches.length === 0 && gone.length === 0) return before;
  const after = new Map(before);
  for (const patch of patches) after.set(patch.id, { ...after.get(patch.id), ...patch } as T);
  for (const id of gone) after.delete(id);
  return after;
}

type Kind = (typeof GONE)[keyof typeof GONE];

function goneByKind(ids: readonly string[]): Record<Kind, string[]> {
  const gone: Record<Kind, string[]> = {
    atvs: [], machines: [], stations: [], tasks: [], orders: [], news: [], alerts: [], faults: [], commands: [],
    closures: [], obstacles: [], waits: [], scenarios: [],
  };
  for (const id of ids) {
    const cut = id.indexOf(":");
    const prefix = id.slice(0, cut);
    // A kind that this version does not show is no concern of ours.
    if (prefix in GONE) gone[GONE[prefix as keyof typeof GONE]].push(id.slice(cut + 1));
  }
  return gone;
}
