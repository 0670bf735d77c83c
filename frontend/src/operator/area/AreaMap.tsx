import { signal } from "@preact/signals";
import { useMemo } from "preact/hooks";
import type { PlantFile } from "../../api/types";
import { wholeOf } from "../../plant/surface/geometry";
import type { Layers } from "../../plant/controls/layers";
import { PlantSurface } from "../../plant/surface/PlantSurface";
import { t } from "../../text/operator";
import { placeName } from "../state";
import { regionOf } from "./region";

const LAYERS = signal<Layers>({ ways: true, traffic: true, primary: false, watch: false, mesh: true, all: false, areas: true, heat: false, labels: true });

/** The operator's own area, live. A touch on a vehicle shows its card. */
export function AreaMap({ plant }: { plant: PlantFile }) {
  const home = useMemo(() => regionOf(plant.areas) ?? wholeOf(plant), [plant]);
  return (
    <section class="map card" aria-label={t("area.title")} style={{ "--aspect": `${home.width_m} / ${home.height_m}` }}>
      <PlantSurface plant={plant} home={home} layers={LAYERS} label={t("area.label", { name: placeName.value })} />
    </section>
  );
}
