/** The sentence for a reason. */
import type { TaskView } from "../../api/types";
import { format, n, t, word } from "../../text";
import { isSilence } from "../news/news-text";
import { auctionOf } from "./auction";
import { type Why, whyOf } from "./why";

/** More names than this are a list, not a sentence. */
const MOST_NAMES = 3;

export function whyText(task: TaskView): string {
  const refused = task.primary === "" ? "" : refusedText(task);
  return [reasonText(whyOf(task)), refused].filter(Boolean).join(" ");
}

export function reasonText(why: Why): string {
  switch (why.kind) {
    case "waiting":
      return why.refused > 0 ? n("why.waitingRefused", why.refused) : t("why.waiting");
    case "leading":
      return t("why.leading", { bidder: why.bidder, total: format.duration(why.totalS) });
    case "withdrawn":
      return t("why.withdrawn", { coordinator: why.coordinator });
    case "only":
      return t("why.only", { winner: why.winner });
    case "tie":
      return t("why.tie", { winner: why.winner, other: why.other });
    case "replaced": {
      const { before, reason, silentS, winner } = why;
      if (isSilence({ reason, silent_s: silentS })) {
        return t("why.replacedSilent", { winner, before, silence: format.age(silentS) });
      }
      return t("why.replaced", { winner, before, reason: word("failure", reason) });
    }
    case "tookOver":
      return t("why.tookOver", { winner: why.winner, before: why.before, epoch: why.epoch });
    case "unknown":
      return t("why.unknown", { winner: why.winner });
    case "part":
      // "Costs less suitability" would be no reason that a person understands.
      if (why.part === "suitability") return t("why.suitability", names(why));
      return t("why.part", { ...names(why), part: word("part", why.part) });
    case "total":
      return t("why.total", names(why));
    case "cheaperDeclined":
      return t("why.cheaperDeclined", { ...names(why), reason: word("reason", why.reason) });
    case "cheaperSilent":
      return t("why.cheaperSilent", names(why));
    case "cheaperAsked":
      return t("why.cheaperAsked", names(why));
  }
}

function names(why: { winner: string; other: string; byS: number }) {
  return { winner: why.winner, other: why.other, by: format.duration(why.byS) };
}

/** Names those who could not because of their battery or ability: the reasons that a person can change. */
function refusedText(task: TaskView): string {
  const telling = auctionOf(task).refusals.filter(({ reason }) => reason === "battery" || reason === "ability");
  const reason = telling[0]?.reason;
  if (reason === undefined) return "";
  const agents = telling.filter((refusal) => refusal.reason === reason).map(({ agent }) => agent);
  if (agents.length > MOST_NAMES) return "";
  return t("why.refused", { names: format.list(agents), reason: word("reason", reason) });
}
