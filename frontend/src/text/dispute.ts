/** What somebody has said that is not believed, in the reader's language; what this version does not know stays as it is. */
import { format, t, word } from "./index";

/** As "a bid with a negative part (3 times)". */
const TIMES = /^(.+) \((\d+) times\)$/;

const HANDOVER = /^says (\d+) of (.+) to (\S+), counted (\d+)$/;

const CLOCK = /^clock wrong by ([+-]\d+) s$/;

export function disputeText(told: string): string {
  const [, what = told, times = ""] = TIMES.exec(told) ?? [];
  const text = whatText(what);
  return times === "" ? text : t("dispute.times", { what: text, times });
}

function whatText(what: string): string {
  const [, said = "", item = "", where = "", counted = ""] = HANDOVER.exec(what) ?? [];
  if (said !== "") return t("dispute.handover", { said, item, where, counted });
  const aheadS = Number(CLOCK.exec(what)?.[1] ?? 0);
  if (aheadS !== 0) return t(aheadS < 0 ? "alerts.what.clock_behind" : "alerts.what.clock_ahead", { by: format.duration(Math.abs(aheadS)) });
  return word("dispute", what);
}
