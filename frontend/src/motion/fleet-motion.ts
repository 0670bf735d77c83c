/** The tracks of the whole fleet: takes in sightings, answers where everybody is shown. */
import type { AtvView } from "../api/types";
import { delayS, nextMoment } from "./playback";
import type { Place, Roads } from "./roads";
import { extend, poseAt, type Sighting, trackOf, type Track, turnTowards } from "./track";

/** Turning on the spot takes about this long on the screen. */
const TURN_S = 0.15;

/** Changed in place: a thousand of them are updated sixty times a second. */
export interface ShownVehicle {
  view: AtvView;
  x: number;
  y: number;
  heading: number;
}

interface Entry {
  track: Track;
  shown: ShownVehicle;
  /** The moment that is shown, on the server's clock; infinite for who wants no motion. */
  atS: number;
  resting: boolean;
}

/** One picture's place in time. */
export interface Tick {
  readonly serverS: number;
  /** Real time since the last picture. */
  readonly passedS: number;
  /** Factory seconds per real second. */
  readonly speed: number;
  /** False for people who asked for less motion: everybody is shown where the last news was. */
  readonly smooth: boolean;
}

export class FleetMotion {
  readonly #roads: Roads;
  readonly #entries = new Map<string, Entry>();

  constructor(roads: Roads) {
    this.#roads = roads;
  }

  /** Forgets everything and takes these as they stand: after a snapshot. */
  reset(atvs: Iterable<AtvView>): void {
    this.#entries.clear();
    for (const view of atvs) this.#enter(view);
  }

  observe(views: readonly AtvView[]): void {
    for (const view of views) {
      const entry = this.#entries.get(view.id);
      if (!entry) {
        this.#enter(view);
        continue;
      }
      entry.shown.view = view;
      const seen = sightingOf(view);
      entry.track = entry.atS === Infinity ? trackOf(seen) : extend(entry.track, seen, this.#roads, entry.atS);
    }
  }

  forget(id: string): void {
    this.#entries.delete(id);
  }

  /**
   * Moves every vehicle to where it is to be shown.
   *
   * @returns whether anything moves or will, so that another picture is needed
   */
  play({ passedS, serverS, smooth, speed }: Tick): boolean {
    let moving = false;
    for (const entry of this.#entries.values()) {
      const { shown, track } = entry;
      const wantedS = serverS - delayS(shown.view.silence.beat_s, speed);
      entry.atS = smooth ? nextMoment(entry.atS, wantedS, passedS, entry.resting) : Infinity;
      const pose = poseAt(track, entry.atS);
      const heading = turnTowards(shown.heading, pose.heading, smooth ? passedS / TURN_S : 1);
      entry.resting = !pose.moving;
      moving ||= pose.moving || Math.abs(heading - shown.heading) > 0.01;
      shown.x = pose.x;
      shown.y = pose.y;
      shown.heading = heading;
    }
    return moving;
  }

  get(id: string): ShownVehicle | undefined {
    return this.#entries.get(id)?.shown;
  }

  /** Where it will go: what is left to play of its track, then its planned way, or the first `nodes` of that. */
  ahead(id: string, nodes = Infinity): Place[] {
    const entry = this.#entries.get(id);
    if (!entry) return [];
    const points: Place[] = [{ x: entry.shown.x, y: entry.shown.y }];
    for (const knot of entry.track.knots) if (knot.t > entry.atS) points.push(knot);
    for (const node of entry.shown.view.way.slice(0, nodes)) {
      const place = this.#roads.places.get(node);
      if (place) points.push(place);
    }
    return points;
  }

  *all(): IterableIterator<ShownVehicle> {
    for (const entry of this.#entries.values()) yield entry.shown;
  }

  get size(): number {
    return this.#entries.size;
  }

  #enter(view: AtvView): void {
    const seen = sightingOf(view);
    this.#entries.set(view.id, {
      track: trackOf(seen),
      shown: { view, x: seen.x, y: seen.y, heading: seen.heading },
      atS: seen.t,
      resting: true,
    });
  }
}

function sightingOf(view: AtvView): Sighting {
  return {
    x: view.x_m,
    y: view.y_m,
    t: view.seen_at_s,
    node: view.node,
    way: view.way,
    heading: view.heading_rad,
  };
}
