import { useSignal } from "@preact/signals";
import { clearObstacle } from "../../../api/client";
import type { ObstacleView } from "../../../api/types";
import { doorOn } from "../../../plant/doors/on";
import { roadOf } from "../../../plant/surface/lanes";
import { nowS, world } from "../../../stream/stream";
import { format, t } from "../../../text/views/floor";
import { problemText } from "../../problem-text";
import { plant } from "../../state";

/** What vehicles have met on lanes, and the word that it is gone. Nothing while all lanes are free. */
export function ObstaclesCard() {
  const obstacles = [...(world.value?.obstacles.values() ?? [])];
  if (obstacles.length === 0) return null;
  return (
    <section class="card closures" aria-labelledby="obstacles">
      <header class="card-head">
        <h2 id="obstacles">{t("obstacles.title")}</h2>
      </header>
      <ul class="closure-list">
        {obstacles.map((obstacle) => (
          <Line key={obstacle.id} obstacle={obstacle} />
        ))}
      </ul>
    </section>
  );
}

function Line({ obstacle }: { obstacle: ObstacleView }) {
  const busy = useSignal(false);
  const failed = useSignal("");
  const { at_s: atS, by, end, start, until_at_s: untilS } = obstacle;
  const clear = async () => {
    busy.value = true;
    failed.value = "";
    try {
      await clearObstacle(start, end);
    } catch (error) {
      failed.value = t("closures.failed", { reason: problemText(error) });
    } finally {
      busy.value = false;
    }
  };
  const where = t("closures.lane", roadOf({ start, end }));
  const door = doorOn(plant.value?.doors ?? [], { start, end })?.name;
  const at = format.due(atS, nowS.value);
  const until = format.due(untilS, nowS.value);
  return (
    <li>
      <p>
        <strong>{door === undefined ? where : t("obstacles.door", { door })}</strong>
        <small class="line muted">{door === undefined ? t("obstacles.seen", { atv: by, at, until }) : t("obstacles.doorSeen", { where, atv: by, at, until })}</small>
        {failed.value !== "" && (
          <small class="line" role="alert">
            {failed.value}
          </small>
        )}
      </p>
      <button type="button" class="button small" disabled={busy.value} aria-label={door === undefined ? t("obstacles.clearedOf", { where }) : t("obstacles.doorClearedOf", { door, where })} onClick={() => void clear()}>
        {t(door === undefined ? "obstacles.cleared" : "obstacles.doorCleared")}
      </button>
    </li>
  );
}
