import type { AtvView } from "../api/types";
import { failureText, untilText } from "../text/failure";
import { t } from "../text";
import { factoryTime } from "../text/plant-time";

interface Props {
  atv: AtvView;
  nowS: number;
  speed: number;
}

/** What a vehicle's body waits for, since when, and what would end that, in its driver's words. */
export function BodyWait({ atv, nowS, speed }: Props) {
  const wait = atv.body_wait;
  if (!wait) return null;
  const time = factoryTime(Math.max(0, nowS - wait.since_at_s) * speed);
  const what = failureText(wait.what);
  return <p class="body-wait">{wait.until === "" ? t("wait.bodyAlone", { time, what }) : t("wait.body", { time, what, until: untilText(wait.until) })}</p>;
}
