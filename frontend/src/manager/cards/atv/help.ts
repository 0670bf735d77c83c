/** How long a vehicle waits for a person, in words. */
import type { HelpView } from "../../../api/types";
import { t } from "../../../text/manager";
import { factoryTime } from "../../../text/plant-time";

/** @returns factory seconds that are left; negative when the time is over */
export function helpLeftS(help: HelpView, nowS: number, speed: number): number {
  return (help.until_at_s - nowS) * speed;
}

export function helpText(help: HelpView, nowS: number, speed: number): string {
  const leftS = helpLeftS(help, nowS, speed);
  const left = factoryTime(leftS, speed);
  if (leftS <= 0) return t("atv.helpLate");
  return help.promised_by === "" ? t("atv.help", { left }) : t("atv.helpPromised", { by: help.promised_by, left });
}
