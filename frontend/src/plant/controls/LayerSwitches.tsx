import { t } from "../../text";
import { withTraffic } from "../held/shown";
import { isCrowded } from "./crowd";
import { layers, layersWith, toggleLayer } from "./layers";

export function LayerSwitches() {
  return (
    <div class="layers" role="group" aria-label={t("map.layers")}>
      {layersWith(withTraffic.value, isCrowded.value).map((layer) => (
        <button
          key={layer}
          type="button"
          class="chip"
          aria-pressed={layers.value[layer]}
          onClick={() => {
            toggleLayer(layer);
          }}
        >
          <span>{t(`map.layer.${layer}`)}</span>
        </button>
      ))}
    </div>
  );
}
