import { Icon, type IconName } from "../../parts/Icon";
import { t } from "../../text";

interface Props {
  zoomBy: (steps: number) => void;
  fit: () => void;
}

export function ZoomButtons({ fit, zoomBy }: Props) {
  const button = (icon: IconName, label: string, onClick: () => void) => (
    <button type="button" class="map-button" aria-label={label} title={label} onClick={onClick}>
      <Icon name={icon} />
    </button>
  );
  return (
    <div class="map-buttons">
      {button("plus", t("map.zoomIn"), () => {
        zoomBy(1);
      })}
      {button("minus", t("map.zoomOut"), () => {
        zoomBy(-1);
      })}
      {button("fit", t("map.fit"), fit)}
    </div>
  );
}
