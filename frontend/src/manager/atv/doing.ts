/** What a vehicle is doing, in words. */
import type { AtvView } from "../../api/types";
import { t, word } from "../../text/manager";

export function doingText(atv: AtvView): string {
  if (atv.task?.phase) return word("phase", atv.task.phase);
  const { berth } = atv;
  if (atv.status === "charging") return berth === "" ? t("atv.charging") : t("atv.atCharger", { berth });
  if (atv.status !== "idle" || berth === "") return word("atv", atv.status);
  return t(atv.way.length > 0 ? "atv.toParking" : "atv.atParking", { berth });
}
