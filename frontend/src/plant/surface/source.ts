/** Where a map's picture comes from: the stream, or a moment of the past. */
import { newestPresentS, newestWorld, onFrame } from "../../stream/stream";
import type { Frame, World } from "../../stream/world";

export interface Source {
  readonly newest: () => World | null;
  /** Hears every frame. Returns how to stop. */
  readonly onFrame: (listener: (frame: Frame, world: World) => void) => () => void;
  /** The moment that is shown, seconds since 1970. */
  readonly presentS: () => number;
}

export const LIVE: Source = { newest: newestWorld, onFrame, presentS: newestPresentS };
