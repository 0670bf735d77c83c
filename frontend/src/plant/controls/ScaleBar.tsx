import { format, t } from "../../text";
import { scaleBar } from "../surface/geometry";

const TARGET_PX = 90;

/** @param scale pixels per metre */
export function ScaleBar({ scale }: { scale: number }) {
  const { metres, px } = scaleBar(scale, TARGET_PX);
  return (
    <div class="scale-bar" aria-hidden="true">
      <i style={{ width: `${px}px` }} />
      <span>{t("map.metres", { n: format.number(metres, metres < 1 ? 1 : 0) })}</span>
    </div>
  );
}
