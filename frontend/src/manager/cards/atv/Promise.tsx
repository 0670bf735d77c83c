import { Fact } from "../../../parts/Facts";
import { world } from "../../../stream/stream";
import { format, t } from "../../../text/manager";
import { factoryTime } from "../../../text/plant-time";

/** What is not worth a word, in factory seconds. */
const PUNCTUAL_S = 2;

interface Props {
  dueAtS: number | null;
  promisedAtS: number | null;
  /** Nothing is heard of it: what it expected is no word on when it comes. */
  lost: boolean;
}

/** When it expects to hand over, against what it promised in its bid. */
export function Promise({ dueAtS, lost, promisedAtS }: Props) {
  if (dueAtS === null) return null;
  if (lost) return <Fact name={t("atv.arrives")}>{t("atv.arrivesSilent")}</Fact>;
  const speed = world.value?.factory.speed ?? 1;
  const lateS = promisedAtS === null ? null : (dueAtS - promisedAtS) * speed;
  return (
    <Fact name={t("atv.arrives")}>
      {format.clock(dueAtS)}
      {lateS !== null && <small class={lateS > PUNCTUAL_S ? "tone-warn" : ""}>{lateText(lateS, speed)}</small>}
    </Fact>
  );
}

function lateText(lateS: number, speed: number): string {
  if (Math.abs(lateS) <= PUNCTUAL_S) return t("atv.onTime");
  return t(lateS > 0 ? "atv.late" : "atv.early", { by: factoryTime(Math.abs(lateS), speed) });
}
