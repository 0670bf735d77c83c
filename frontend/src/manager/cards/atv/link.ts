/** By which way a vehicle is heard, in words. */
import type { AtvView } from "../../../api/types";
import { t } from "../../../text/manager";

export function linkText({ link, via }: Pick<AtvView, "link" | "via">): string {
  if (link === "wlan") return t("atv.wlan");
  return via.length === 0 ? t("atv.meshNobody") : t("atv.mesh", { via: via.join(" → ") });
}
