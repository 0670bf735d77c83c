import type { ReadonlySignal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect, useMemo, useRef } from "preact/hooks";
import type { PlantFile } from "../api/types";
import { onFrame } from "../stream/stream";
import { t } from "../text";
import { Finder } from "./controls/Finder";
import { wholeOf } from "./surface/geometry";
import { LayerSwitches } from "./controls/LayerSwitches";
import { layers } from "./controls/layers";
import { type Findable, pickablesOf } from "./places";
import { PlantSurface, type Surface } from "./surface/PlantSurface";
import { followTraffic, heat } from "./heat/traffic";

/** A hand that moves the map by less means to choose something. */
const DRAGGED_PX = 2;
const MOVED_M = 0.05;

interface Props {
  plant: PlantFile;
  over?: ComponentChildren;
  /** Beside the switches of the layers. */
  aside?: ComponentChildren;
  /** The vehicle that stays in the middle; null for none. */
  followed?: ReadonlySignal<string | null>;
  /** Called when somebody moves the map by hand. */
  onMoved?: () => void;
}

function isOnFloor({ target }: Event): boolean {
  return target instanceof Element && target.closest(".map-surface") !== null;
}

/** The whole plant. Everything on it can also be chosen in the field Find and in the lists. */
export function PlantMap({ aside, followed, onMoved, over, plant }: Props) {
  const surface = useRef<Surface | null>(null);
  const home = useMemo(() => wholeOf(plant), [plant]);
  const onSurface = useMemo(() => (now: Surface | null) => (surface.current = now), []);
  useEffect(followTraffic, []);
  useEffect(() => {
    let centred = { x: NaN, y: NaN };
    return onFrame(() => {
      const { navigation, renderer } = surface.current ?? {};
      const vehicle = renderer?.fleet.get(followed?.peek() ?? "");
      // Everything is drawn anew for it: not for who stands.
      if (!vehicle || !navigation || Math.hypot(vehicle.x - centred.x, vehicle.y - centred.y) < MOVED_M) return;
      centred = { x: vehicle.x, y: vehicle.y };
      navigation.goTo(vehicle);
    });
  }, [followed]);
  const goTo = (found: Findable): void => {
    const { renderer, navigation } = surface.current ?? {};
    const vehicle = renderer?.fleet.get(found.id);
    const box = pickablesOf(plant).find(({ id }) => id === found.id)?.box;
    if (vehicle) navigation?.bring(vehicle);
    else if (box) navigation?.bring({ x: box.x_m, y: box.y_m });
  };
  return (
    <section class="map card" aria-label={t("map.title")} onPointerMoveCapture={(event) => {
      if (event.buttons !== 0 && Math.abs(event.movementX) + Math.abs(event.movementY) > DRAGGED_PX && isOnFloor(event)) onMoved?.();
    }} onKeyDownCapture={(event) => {
      if (event.key.startsWith("Arrow") && isOnFloor(event)) onMoved?.();
    }}>
      <div class="map-head">
        <LayerSwitches />
        <div class="map-tail">
          {aside}
          <Finder plant={plant} onChosen={goTo} />
        </div>
      </div>
      <PlantSurface
        plant={plant}
        home={home}
        layers={layers}
        heat={heat}
        label={t("map.label", { name: plant.name })}
        over={over}
        withLanes
        onSurface={onSurface}
      />
    </section>
  );
}
