/** What the gateway does not name to its reader, because it stands outside of the reader's areas. */
import { t } from "./index";

/** As the gateway writes such a vehicle (`gateway/live/visibility.py`), alone and within sentences. */
const ELSEWHERE = "*";
const WITHIN = /(?<![\p{L}\p{N}*])\*(?![\p{L}\p{N}*])/gu;

/** The name of a vehicle, or "a vehicle elsewhere". */
export function vehicleName(atv: string): string {
  return atv === ELSEWHERE ? t("wait.elsewhere") : atv;
}

/** A sentence that somebody else wrote, in which vehicles elsewhere are words. */
export function withNames(said: string): string {
  return said.includes(ELSEWHERE) ? said.replace(WITHIN, () => t("wait.elsewhere")) : said;
}
