/** Pan and zoom of the map: wheel, pinch, drag, buttons and keys, within sensible bounds. */
import { select } from "d3-selection";
import { zoom, zoomIdentity, type ZoomBehavior } from "d3-zoom";
import { centredOn, isInSight, type Zoom } from "./geometry";
import type { PlantRenderer } from "../draw/renderer";

/** Pixels per metre: closer than this a machine would fill the map. */
const CLOSEST = 90;
const FURTHEST_K = 0.7;
const KEY_STEP_PX = 60;
const BUTTON_STEP = 1.5;
/** Nearer to the edge something is easily overlooked. */
const MARGIN_PX = 24;

export interface Navigation {
  zoomBy: (steps: number) => void;
  fit: () => void;
  /** Brings a point of the floor into the middle, and near enough to be recognised. */
  goTo: (point: { x: number; y: number }) => void;
  /** The same, where it is not in sight already. */
  bring: (point: { x: number; y: number }) => void;
  key: (event: KeyboardEvent) => void;
  resized: () => void;
  stop: () => void;
}

export function navigate(surface: HTMLElement, renderer: PlantRenderer): Navigation {
  const behaviour: ZoomBehavior<HTMLElement, unknown> = zoom<HTMLElement, unknown>()
    .on("zoom", (event: { transform: Zoom }) => {
      renderer.zoomTo(event.transform);
    });
  const node = select(surface);
  node.call(behaviour).on("dblclick.zoom", null);
  let current: Zoom = zoomIdentity;
  behaviour.on("zoom.keep", (event: { transform: Zoom }) => {
    current = event.transform;
  });
  const set = (to: Zoom): void => {
    behaviour.transform(node, zoomIdentity.translate(to.x, to.y).scale(to.k));
  };
  const navigation: Navigation = {
    zoomBy: (steps) => {
      behaviour.scaleBy(node, BUTTON_STEP ** steps);
    },
    fit: () => {
      set(zoomIdentity);
    },
    goTo: (point) => {
      set(centredOn(renderer.fit, renderer.size, point, Math.max(current.k, 1)));
    },
    bring: (point) => {
      if (!isInSight(renderer.view, renderer.size, point, MARGIN_PX)) navigation.goTo(point);
    },
    key: (event) => {
      const pan = PANS[event.key];
      if (pan) behaviour.translateBy(node, (pan[0] * KEY_STEP_PX) / current.k, (pan[1] * KEY_STEP_PX) / current.k);
      else if (event.key === "+" || event.key === "=") navigation.zoomBy(1);
      else if (event.key === "-") navigation.zoomBy(-1);
      else if (event.key === "0") navigation.fit();
      else return;
      event.preventDefault();
    },
    resized: () => {
      const { width, height } = renderer.size;
      behaviour.scaleExtent([FURTHEST_K, Math.max(2, CLOSEST / renderer.fit.scale)]);
      behaviour.extent([[0, 0], [width, height]]);
      behaviour.translateExtent([[-0.5 * width, -0.5 * height], [1.5 * width, 1.5 * height]]);
    },
    stop: () => {
      node.on(".zoom", null);
    },
  };
  return navigation;
}

/** The map moves against the key, so that the eye goes with it. */
const PANS: Readonly<Partial<Record<string, readonly [number, number]>>> = {
  ArrowLeft: [1, 0],
  ArrowRight: [-1, 0],
  ArrowUp: [0, 1],
  ArrowDown: [0, -1],
};
