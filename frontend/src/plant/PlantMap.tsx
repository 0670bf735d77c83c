import type { ComponentChildren } from "preact";
import { useEffect, useMemo, useRef } from "preact/hooks";
import type { PlantFile } from "../api/types";
import { t } from "../text";
import { Finder } from "./controls/Finder";
import { wholeOf } from "./surface/geometry";
import { LayerSwitches } from "./controls/LayerSwitches";
import { layers } from "./controls/layers";
import { type Findable, pickablesOf } from "./places";
import { PlantSurface, type Surface } from "./surface/PlantSurface";
import { followTraffic, heat } from "./heat/traffic";

/** The whole plant. Everything on it can also be chosen in the field Find and in the lists. */
export function PlantMap({ over, plant }: { over?: ComponentChildren; plant: PlantFile }) {
  const surface = useRef<Surface | null>(null);
  const home = useMemo(() => wholeOf(plant), [plant]);
  const onSurface = useMemo(() => (now: Surface | null) => (surface.current = now), []);
  useEffect(followTraffic, []);
  const goTo = (found: Findable): void => {
    const { renderer, navigation } = surface.current ?? {};
    const vehicle = renderer?.fleet.get(found.id);
    const box = pickablesOf(plant).find(({ id }) => id === found.id)?.box;
    if (vehicle) navigation?.goTo(vehicle);
    else if (box) navigation?.goTo({ x: box.x_m, y: box.y_m });
  };
  return (
    <section class="map card" aria-label={t("map.title")}>
      <div class="map-head">
        <LayerSwitches />
        <Finder plant={plant} onChosen={goTo} />
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
