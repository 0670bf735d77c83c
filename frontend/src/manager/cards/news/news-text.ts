/** News in words. */
import type { ClosureView, NewsView } from "../../../api/types";
import { causeText, reasonText } from "../../../text/failure";
import { format, t } from "../../../text/manager";
import { factoryTime } from "../../../text/plant-time";

/** What people call what agents know by ids of their own. */
export interface Called {
  /** As "24 Gear unit G2". */
  readonly goal: (id: string) => string;
  /** The customer's reference. */
  readonly order: (id: string) => string;
  /** What was closed, and how. */
  readonly closure: (closure: ClosureView) => { readonly where: string; readonly how: string };
}

export function newsText(news: NewsView, nowS: number, called: Called): string {
  const { agent, arrived, closure, confirmed, other, successor, task } = news;
  const agents = format.list(news.agents.length > 0 ? news.agents : [agent]);
  const goal = called.goal(news.goal);
  const silence = factoryTime(news.silent_s, undefined, "age");
  const reason = news.cause === null ? reasonText(news.reason) : causeText(news.cause);
  const until = format.due(news.until_at_s ?? nowS, nowS);
  const names = { agent, task, other };
  switch (news.kind) {
    case "took_over":
      if (isSilence(news)) return t(confirmed ? "news.tookSilent" : "news.takingSilent", { ...names, silence });
      return t(confirmed ? "news.took" : "news.taking", { ...names, reason });
    case "takeover_refused":
      return t("news.refused", names);
    case "announced_anew":
      return isSilence(news) ? t("news.anewSilent", { ...names, silence }) : t("news.anew", { ...names, reason });
    case "link_lost":
      return t("news.linkLost", { agent });
    case "link_back":
      return t("news.linkBack", { agent });
    case "help_asked":
      return t("news.helpAsked", { agent, reason, until });
    case "help_promised":
      return t("news.helpPromised", { agent, by: other, until });
    case "goal_lost":
      if (successor === "") return t("news.goalLostWhole", { agent, goal });
      return t("news.goalLost", { agent, goal, arrived: format.count(arrived) });
    case "goal_waits":
      return t("news.goalWaits", { order: called.order(news.order), reason });
    case "memory_lost":
      return t("news.memoryLost", { agent, reason });
    case "silent":
      return t("news.silent", { agents });
    case "heard_again":
      return t("news.heardAgain", { agents, silence });
    case "carried_away":
      return t("news.carriedAway", { agent, by: other });
    case "put_back":
      return t("news.putBack", { agent });
    case "stopped":
      return t("news.stopped", { agents, by: other });
    case "closed":
      return closure === null ? "" : t("news.closed", { by: other, reason: closure.reason, ...called.closure(closure) });
    case "opened":
      return closure === null ? "" : t("news.opened", called.closure(closure));
  }
}

/** Whether silence was the reason: how long it was then says it best. */
export function isSilence(change: { reason: string; silent_s: number }): boolean {
  return change.reason === "silent" && change.silent_s > 0;
}
