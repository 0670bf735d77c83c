/** What lacks where a transport is to be fetched, and who has as much, in words. */
import type { components } from "../api/types";
import type { waits } from "./shared/waits/en";
import { format, textsOf } from "./speech";

const { t } = textsOf<typeof waits>();

/** As "Free in S3: 12. Ordered there: 40. As much is at S5."; empty where nothing lacks. */
export function shortageText(source: string, shortage: components["schemas"]["Shortage"] | null): string {
  if (shortage === null) return "";
  const { elsewhere, free, on_order: coming } = shortage;
  return [
    t("calling.shortage.free", { place: source, free: format.count(free) }),
    coming > 0 ? t("calling.shortage.coming", { quantity: format.count(coming) }) : "",
    elsewhere.length > 0 ? t("calling.shortage.elsewhere", { places: format.list(elsewhere) }) : "",
  ].filter((said) => said !== "").join(" ");
}
