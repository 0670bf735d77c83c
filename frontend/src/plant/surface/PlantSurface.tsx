/** The floor with everything on it, live: pan, zoom, and choose by a click. */
import { type ReadonlySignal, useSignal, useSignalEffect } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect, useRef } from "preact/hooks";
import type { PlantFile } from "../../api/types";
import { type Chosen, choose, selection } from "../../selection/selection";
import { ageS, freshness } from "../../stream/stream";
import { isPast } from "../../stream/freshness";
import { format, t } from "../../text";
import { colours } from "../../theme/theme";
import { outline, withCorner } from "../../selection/outline";
import { type Region, toFloorX, toFloorY } from "./geometry";
import type { Heat } from "../heat/heat";
import { HeatLegend } from "../heat/HeatLegend";
import type { Layers } from "../controls/layers";
import { type Navigation, navigate } from "./navigation";
import { type Palette, readPalette } from "../draw/palette";
import { pickLane } from "./lanes";
import { pick } from "./pick";
import { pickablesOf } from "../places";
import { PlantRenderer } from "../draw/renderer";
import { ScaleBar } from "../controls/ScaleBar";
import { LIVE, type Source } from "./source";
import { ZoomButtons } from "../controls/ZoomButtons";

export interface Surface {
  readonly renderer: PlantRenderer;
  readonly navigation: Navigation;
}

interface Props {
  readonly plant: PlantFile;
  /** What fills the surface at first. */
  readonly home: Region;
  readonly layers: ReadonlySignal<Layers>;
  readonly label: string;
  /** The traffic on the lanes, where it is to be seen. */
  readonly heat?: ReadonlySignal<Heat | null>;
  readonly over?: ComponentChildren;
  /** What is shown; the stream where nothing else is said. */
  readonly source?: Source;
  /** Whether lanes can be chosen, too. */
  readonly withLanes?: boolean;
  /** Is told the surface when it is there, and null when it is gone. */
  readonly onSurface?: (surface: Surface | null) => void;
}

export function PlantSurface({ heat, home, label, layers, onSurface, over, plant, source = LIVE, withLanes = false }: Props) {
  const element = useRef<HTMLDivElement>(null);
  const canvases = [useRef<HTMLCanvasElement>(null), useRef<HTMLCanvasElement>(null), useRef<HTMLCanvasElement>(null)];
  const surface = useSignal<Surface | null>(null);
  const scale = useSignal(1);
  const [floor, machines, moving] = canvases;

  useEffect(() => {
    const on = element.current;
    if (!on || !floor?.current || !machines?.current || !moving?.current) return undefined;
    const layered = { floor: floor.current, machines: machines.current, moving: moving.current };
    const shown = shownNow(readPalette(on), layers.peek(), heat?.peek() ?? null, withLanes);
    const renderer = new PlantRenderer({ plant, home }, layered, shown, source.presentS);
    const navigation = navigate(on, renderer);
    const stop = follow(on, { renderer, navigation, source }, withLanes, (px) => (scale.value = px));
    surface.value = { renderer, navigation };
    onSurface?.(surface.value);
    return () => {
      stop();
      surface.value = null;
      onSurface?.(null);
    };
  }, [plant, home, layers, heat, onSurface, source, withLanes, floor, machines, moving, surface, scale]);

  useSignalEffect(() => {
    const shown = shownNow(paletteOf(element.current, colours.value), layers.value, heat?.value ?? null, withLanes);
    surface.value?.renderer.show(shown);
  });

  const past = source === LIVE && isPast(freshness.value);
  return (
    <div class={`map-floor ${past ? "map-past" : ""}`}>
      <div
        ref={element}
        class="map-surface"
        id="plant-map"
        tabIndex={0}
        role="application"
        aria-label={label}
        onKeyDown={(event) => {
          const { navigation, renderer } = surface.value ?? {};
          if (renderer && withLanes && outline.value.drawing && event.key === "Enter") {
            setCorner(renderer, renderer.size.width / 2, renderer.size.height / 2);
            event.preventDefault();
          } else navigation?.key(event);
        }}
      >
        {canvases.map((canvas, i) => (
          <canvas key={i} ref={canvas} aria-hidden="true" />
        ))}
      </div>
      {past && ageS.value !== null && <p class="map-age">{t("map.past", { age: format.age(ageS.value) })}</p>}
      {over}
      {heat?.value && <HeatLegend heat={heat.value} />}
      <ScaleBar scale={scale.value} />
      <ZoomButtons
        zoomBy={(steps) => surface.value?.navigation.zoomBy(steps)}
        fit={() => surface.value?.navigation.fit()}
      />
    </div>
  );
}

/** One corner more, at a point of the screen. */
function setCorner({ plant, view }: PlantRenderer, x: number, y: number): void {
  outline.value = withCorner(outline.value, toFloorX(view, x), toFloorY(view, y), plant);
}

let painted: { of: number; palette: Palette } | null = null;

/** Colours are read from the page once per theme, not once per picture. */
function paletteOf(element: Element | null, version: number): Palette {
  if (painted?.of !== version) {
    painted = { of: version, palette: readPalette(element ?? document.documentElement) };
  }
  return painted.palette;
}

function shownNow(palette: Palette, layers: Layers, heat: Heat | null, withOutline: boolean) {
  const { atv, lane, place, standby } = selection.value;
  const drawn = outline.value;
  return { palette, layers, heat, atv, standby, lane, place: place?.id ?? null, outline: withOutline && (drawn.drawing || drawn.corners.length > 0) ? drawn : null };
}

/** Ties the renderer to the page: frames, size, fonts, pointer and the wish for less motion. */
function follow(
  element: HTMLElement,
  { navigation, renderer, source }: Surface & { source: Source },
  withLanes: boolean,
  onScale: (pxPerM: number) => void,
): () => void {
  const known = source.newest();
  if (known) renderer.begin(known);
  const unlisten = source.onFrame((frame, world) => {
    renderer.take(frame, world);
  });
  const resizing = new ResizeObserver(([entry]) => {
    if (!entry) return;
    const { height, width } = entry.contentRect;
    renderer.resize({ width, height });
    navigation.resized();
    onScale(renderer.view.scale);
  });
  resizing.observe(element);
  const calm = matchMedia("(prefers-reduced-motion: reduce)");
  const setMotion = (): void => {
    renderer.setSmooth(!calm.matches);
  };
  setMotion();
  calm.addEventListener("change", setMotion);
  void document.fonts.ready.then(() => {
    renderer.redraw();
  });
  const places = pickablesOf(renderer.plant);
  const chosenAt = (event: MouseEvent): Chosen | null => {
    const rect = element.getBoundingClientRect();
    const x = event.clientX - rect.left;
    const y = event.clientY - rect.top;
    const chosen = pick(renderer.view, x, y, renderer.fleet.all(), places);
    const lane = withLanes && !chosen ? pickLane(renderer.view, renderer.plant, x, y) : null;
    return lane === null ? chosen : { kind: "lane", id: lane };
  };
  const onClick = (event: MouseEvent): void => {
    if (withLanes && outline.value.drawing) {
      const rect = element.getBoundingClientRect();
      setCorner(renderer, event.clientX - rect.left, event.clientY - rect.top);
      return;
    }
    const chosen = chosenAt(event);
    if (chosen) choose(chosen);
  };
  const onMove = (event: MouseEvent): void => {
    element.style.cursor = withLanes && outline.value.drawing ? "crosshair" : chosenAt(event) ? "pointer" : "";
  };
  const onZoom = (): void => {
    onScale(renderer.view.scale);
  };
  element.addEventListener("click", onClick);
  element.addEventListener("pointermove", onMove);
  renderer.onZoom = onZoom;
  return () => {
    unlisten();
    resizing.disconnect();
    calm.removeEventListener("change", setMotion);
    element.removeEventListener("click", onClick);
    element.removeEventListener("pointermove", onMove);
    navigation.stop();
    renderer.stop();
  };
}
