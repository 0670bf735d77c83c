/**
 * What the stream has told so far, as plain data, and how a frame changes it. Pure: a frame in, a new
 * world out. Who reads the socket, and when a panel redraws, is decided elsewhere.
 */
import type { AudienceView, Delta, FactoryView, Snapshot } from "../api/types";

export type Frame = Snapshot | Delta;

/** Every kind of thing in the stream: the prefix of its ids in `Delta.gone`, and its collection in frames. */
export const COLLECTIONS = {
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

export type Collection = (typeof COLLECTIONS)[keyof typeof COLLECTIONS];

/** The things of each collection by id, in the stream's order; `Snapshot` says what each collection holds. */
type Collected = { readonly [name in Collection]: ReadonlyMap<string, Snapshot[name][number]> };

export interface World extends Collected {
  /** Number of the frame that this world is the result of. */
  readonly number: number;
  /** The server's clock when it sent that frame, seconds since 1970. */
  readonly atS: number;
  readonly plant: string;
  readonly factory: FactoryView;
  /** Whether faults can be begun by hand. */
  readonly fault_injection: boolean;
  /** Who is shown all this, and how much of the plant. */
  readonly audience: AudienceView | null;
}

const NAMES: readonly Collection[] = Object.values(COLLECTIONS);

function collected(of: (name: Collection) => ReadonlyMap<string, { id: string }>): Collected {
  return Object.fromEntries(NAMES.map((name) => [name, of(name)])) as unknown as Collected;
}

export function worldOf(frame: Snapshot): World {
  return {
    number: frame.number,
    atS: frame.at_s,
    plant: frame.plant,
    factory: frame.factory,
    fault_injection: frame.fault_injection,
    audience: frame.audience,
    ...collected((name) => byId<{ id: string }>(frame[name])),
  };
}

/**
 * The world after a frame, or null where the frame does not follow: a number is missing, or the
 * stream began without a snapshot. Then only a fresh snapshot helps.
 */
export function advance(world: World | null, frame: Frame): World | null {
  if (frame.type === "snapshot") return worldOf(frame);
  if (world === null || frame.number !== world.number + 1) return null;
  const gone = goneOf(frame.gone);
  return {
    ...world,
    number: frame.number,
    atS: frame.at_s,
    factory: frame.factory ?? world.factory,
    ...collected((name) => changed<{ id: string }>(world[name], frame[name], gone[name])),
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

function goneOf(ids: readonly string[]): Record<Collection, string[]> {
  const gone = Object.fromEntries(NAMES.map((name) => [name, [] as string[]])) as Record<Collection, string[]>;
  for (const id of ids) {
    const cut = id.indexOf(":");
    const prefix = id.slice(0, cut);
    // A kind that this version does not show is no concern of ours.
    if (prefix in COLLECTIONS) gone[COLLECTIONS[prefix as keyof typeof COLLECTIONS]].push(id.slice(cut + 1));
  }
  return gone;
}
