import { useSignal, useSignalEffect } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect, useRef } from "preact/hooks";
import type { PlantFile } from "../api/types";
import { choose, selection } from "../selection/selection";
import { ageS, freshness, newestWorld, onFrame, serverNowS } from "../stream/stream";
import { isPast } from "../stream/freshness";
import { format, t } from "../text";
import { colours } from "../theme/theme";
import { Finder } from "./Finder";
import { LayerSwitches } from "./LayerSwitches";
import { layers } from "./layers";
import { type Navigation, navigate } from "./navigation";
import { type Palette, readPalette } from "./palette";
import { pick } from "./pick";
import { type Findable, pickablesOf } from "./places";
import { PlantRenderer } from "./renderer";
import { ScaleBar } from "./ScaleBar";
import { ZoomButtons } from "./ZoomButtons";

interface Parts {
  renderer: PlantRenderer;
  navigation: Navigation;
}

/** The plant, live, with something laid over it. Everything on it can also be chosen in the field Find and in the lists. */
export function PlantMap({ over, plant }: { over?: ComponentChildren; plant: PlantFile }) {
  const surface = useRef<HTMLDivElement>(null);
  const canvases = [useRef<HTMLCanvasElement>(null), useRef<HTMLCanvasElement>(null), useRef<HTMLCanvasElement>(null)];
  const parts = useSignal<Parts | null>(null);
  const scale = useSignal(1);
  const [floor, machines, moving] = canvases;

  useEffect(() => {
    const element = surface.current;
    if (!element || !floor?.current || !machines?.current || !moving?.current) return undefined;
    const layered = { floor: floor.current, machines: machines.current, moving: moving.current };
    const renderer = new PlantRenderer(plant, layered, shownNow(readPalette(element)), serverNowS);
    const navigation = navigate(element, renderer);
    const stop = follow(element, renderer, navigation, (px) => (scale.value = px));
    parts.value = { renderer, navigation };
    return () => {
      stop();
      parts.value = null;
    };
  }, [plant, floor, machines, moving, parts, scale]);

  useSignalEffect(() => {
    const shown = shownNow(paletteOf(surface.current, colours.value));
    parts.value?.renderer.show(shown);
  });

  const past = isPast(freshness.value);
  const goTo = (found: Findable): void => {
    const { renderer, navigation } = parts.value ?? {};
    const vehicle = renderer?.fleet.get(found.id);
    const box = pickablesOf(plant).find(({ id }) => id === found.id)?.box;
    if (vehicle) navigation?.goTo(vehicle);
    else if (box) navigation?.goTo({ x: box.x_m, y: box.y_m });
  };
  return (
    <section class={`map card ${past ? "map-past" : ""}`} aria-label={t("map.title")}>
      <div class="map-head">
        <LayerSwitches />
        <Finder plant={plant} onChosen={goTo} />
      </div>
      <div class="map-floor">
        <div
        ref={surface}
        class="map-surface"
        id="plant-map"
        tabIndex={0}
        role="application"
        aria-label={t("map.label", { name: plant.name })}
        onKeyDown={(event) => parts.value?.navigation.key(event)}
      >
        {canvases.map((canvas, i) => (
          <canvas key={i} ref={canvas} aria-hidden="true" />
        ))}
      </div>
      {past && ageS.value !== null && (
        <p class="map-age">{t("map.past", { age: format.age(ageS.value) })}</p>
      )}
      {over}
      <ScaleBar scale={scale.value} />
      <ZoomButtons
        zoomBy={(steps) => parts.value?.navigation.zoomBy(steps)}
        fit={() => parts.value?.navigation.fit()}
      />
      </div>
    </section>
  );
}

let painted: { of: number; palette: Palette } | null = null;

/** Colours are read from the page once per theme, not once per picture. */
function paletteOf(element: Element | null, version: number): Palette {
  if (painted?.of !== version) {
    painted = { of: version, palette: readPalette(element ?? document.documentElement) };
  }
  return painted.palette;
}

function shownNow(palette: Palette) {
  const { atv, place } = selection.value;
  return { palette, layers: layers.value, atv, place: place?.id ?? null };
}

/** Ties the renderer to the page: frames, size, fonts, pointer and the wish for less motion. */
function follow(
  element: HTMLElement,
  renderer: PlantRenderer,
  navigation: Navigation,
  onScale: (pxPerM: number) => void,
): () => void {
  const known = newestWorld();
  if (known) renderer.begin(known);
  const unhear = onFrame((frame, world) => {
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
  const chosenAt = (event: MouseEvent) => {
    const rect = element.getBoundingClientRect();
    return pick(renderer.view, event.clientX - rect.left, event.clientY - rect.top, renderer.fleet.all(), places);
  };
  const onClick = (event: MouseEvent): void => {
    const chosen = chosenAt(event);
    if (chosen) choose(chosen);
  };
  const onMove = (event: MouseEvent): void => {
    element.style.cursor = chosenAt(event) ? "pointer" : "";
  };
  const onZoom = (): void => {
    onScale(renderer.view.scale);
  };
  element.addEventListener("click", onClick);
  element.addEventListener("pointermove", onMove);
  renderer.onZoom = onZoom;
  return () => {
    unhear();
    resizing.disconnect();
    calm.removeEventListener("change", setMotion);
    element.removeEventListener("click", onClick);
    element.removeEventListener("pointermove", onMove);
    navigation.stop();
    renderer.stop();
  };
}
