import { doorOn } from "../../../plant/doors/on";
import { laneOf } from "../../../plant/surface/lanes";
import { selection } from "../../../selection/selection";
import { world } from "../../../stream/stream";
import { t } from "../../../text/views/faults";
import { PopButton } from "../../parts/PopButton";
import { plant } from "../../state";
import { beginOnLane, busy, end, failDoor, failed } from "./act";
import { LANE, onLane, THINGS } from "./faults";

/** What may be in the way on the lane that is chosen on the map. Absent while no lane is chosen. */
export function LaneFaultMenu() {
  const known = world.value;
  const { lane: chosen } = selection.value;
  const lane = chosen === null ? null : laneOf(chosen);
  if (!known || !lane) return null;
  // A stuck door is one that the plant has; where it has none, one is made up.
  const door = doorOn(plant.value?.doors ?? [], lane);
  const there = onLane(known.faults.values(), lane, door?.id);
  const complaint = failed.value?.agent === LANE ? failed.value.text : "";
  return (
    <PopButton icon="fault" label={t("fault.lane.title")} title={t("fault.lane.hint", lane)}>
      {(close) => (
        <>
          <p class="faint">{t("fault.lane.hint", lane)}</p>
          {THINGS.map((thing) => (
            <button
              key={thing}
              type="button"
              class="fault-choice"
              disabled={busy.value || there.length > 0}
              onClick={() => void (door && thing === "door" ? failDoor(door.id) : beginOnLane(lane, thing))}
            >
              {door && thing === "door" ? t("fault.lane.ownDoor", { door: door.name }) : t(`fault.lane.${thing}`)}
            </button>
          ))}
          {there.map(({ id }) => (
            <button
              key={id}
              type="button"
              class="fault-choice"
              disabled={busy.value}
              onClick={() => {
                close();
                void end(id, LANE);
              }}
            >
              {t("fault.end")}
            </button>
          ))}
          {complaint !== "" && (
            <p class="complaint" role="alert">
              {complaint}
            </p>
          )}
        </>
      )}
    </PopButton>
  );
}
