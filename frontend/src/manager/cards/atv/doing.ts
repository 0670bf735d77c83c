/** What a vehicle is doing, in words. */
import type { AtvView } from "../../../api/types";
import { t, word } from "../../../text/manager";

export function doingText(atv: AtvView): string {
  if (atv.task?.phase) return word("phase", atv.task.phase);
  const place = atv.dwell_point;
  if (atv.sent_to_charge && atv.status === "idle") return t("atv.sentToCharge");
  if (atv.status === "charging") return place === "" ? t("atv.charging") : t("atv.atCharger", { place });
  if (atv.status !== "idle" || place === "") return word("atv", atv.status);
  return t(atv.way.length > 0 ? "atv.toParking" : "atv.atParking", { place });
}
