import type { AtvView } from "../api/types";
import { format, t } from "../text";

/** How full a vehicle's battery is; "about" where the vehicle does not say it, and it is reckoned. */
export function batteryText({ battery_frac: frac, battery_reckoned: reckoned }: Pick<AtvView, "battery_frac" | "battery_reckoned">): string {
  const percent = format.percent(frac);
  return reckoned ? t("atv.batteryAbout", { percent }) : percent;
}
