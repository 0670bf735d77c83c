import type { AtvView } from "../../../api/types";
import { Fact } from "../../../parts/Facts";
import { presentS, world } from "../../../stream/stream";
import { format, t } from "../../../text/manager";
import { factoryTime } from "../../../text/plant-time";
import { waitText } from "../../../text/wait";
import { type Arrival, arrivalOf } from "./arrival";

interface Props {
  atv: AtvView;
  promisedAtS: number | null;
  /** Nothing is heard of it: what it expected is no word on when it comes. */
  lost: boolean;
}

/** When it expects to hand over, against what it promised in its bid. */
export function Promise({ atv, lost, promisedAtS }: Props) {
  const dueAtS = atv.task?.due_at_s ?? null;
  if (dueAtS === null) return null;
  const speed = world.value?.factory.speed ?? 1;
  const wait = world.value?.waits.get(atv.id);
  const arrival = arrivalOf({ atv, dueAtS, lost, nowS: presentS.value, promisedAtS, speed, waits: wait !== undefined });
  const cause = wait === undefined ? "" : waitText(wait.cause);
  return <Fact name={t("atv.arrives")}>{arrivalText(arrival, speed, cause)}</Fact>;
}

function arrivalText(arrival: Arrival, speed: number, cause: string) {
  switch (arrival.kind) {
    case "silent":
      return t("atv.arrivesSilent");
    case "stands":
      return t("atv.arrivesStands");
    case "heldUp":
      return (
        <>
          {t("atv.arrivesHeldUp", { cause })}
          {arrival.lateS !== null && <small class="tone-warn">{t("atv.lateSoFar", { by: factoryTime(arrival.lateS, speed) })}</small>}
        </>
      );
    case "overdue":
      return <span class="tone-warn">{t("atv.arrivesOverdue", { at: format.clock(arrival.atS), by: factoryTime(arrival.byS, speed) })}</span>;
    case "expected":
      return (
        <>
          {format.clock(arrival.atS)}
          {arrival.word !== null && (
            <small class={arrival.word === "late" ? "tone-warn" : ""}>
              {arrival.word === "onTime" ? t("atv.onTime") : t(`atv.${arrival.word}`, { by: factoryTime(arrival.byS, speed) })}
            </small>
          )}
        </>
      );
  }
}
