import { MOST_CORNERS, NOTHING_DRAWN, outline } from "../../../selection/outline";
import { t } from "../../../text/manager";

/** Over the map while a part of the floor is being drawn: what to do, and the way back. */
export function DrawStrip() {
  const { corners, drawing } = outline.value;
  if (!drawing && corners.length === 0) return null;
  const undo = () => {
    outline.value = { drawing: true, corners: corners.slice(0, -1) };
  };
  const discard = () => {
    outline.value = NOTHING_DRAWN;
  };
  return (
    <div class="draw-strip" role="status">
      <p>{t(corners.length < 2 ? "closures.drawing" : "closures.drawn", { corners: corners.length, most: MOST_CORNERS })}</p>
      <button type="button" class="button small" disabled={corners.length === 0} onClick={undo}>
        {t("closures.undo")}
      </button>
      <button type="button" class="button small" onClick={discard}>
        {t("closures.discard")}
      </button>
    </div>
  );
}
