/**
 * "Why this vehicle?" in words. The gateway has the reasons, computed from the bids; here they are put
 * into the reader's language.
 */
import type { PassedView, RefusedView, TaskView, WhyView } from "../../../api/types";
import { failureText, reasonText } from "../../../text/failure";
import { format, n, t, word } from "../../../text/manager";
import { ofFactoryTime } from "../../../text/plant-time";
import { watchers } from "./auction";
import { isSilence } from "../news/news-text";

/** Bidders that were passed over and are named; more would make a list of a sentence. */
const PASSED_NAMED = 2;
/** What has gone through no rounds of bidding, or not through those that are told. */
const WITHOUT_ROUNDS = new Set<WhyView["kind"]>(["took_over", "recovered", "unknown", "withdrawn"]);

/** @param speed factory seconds per real second, where it is not that of the plant as it is now */
export function whyText(task: Pick<TaskView, "why"> & Partial<Pick<TaskView, "bids" | "secondary">>, speed?: number): string {
  const why = withoutWatchers(task.why, watchers({ bids: task.bids ?? [], secondary: task.secondary ?? "" }));
  const text = [mainText(why), anewText(why), roundsText(why)].filter(Boolean).join(" ");
  return why.total_s > 0 || why.silent_s > 0 ? ofFactoryTime(text, speed) : text;
}

/** The sentence says what is seen below it: who offers to watch is not among those that refused. */
function withoutWatchers(why: WhyView, watching: ReadonlySet<string>): WhyView {
  const refused = why.refused.map((each) => ({ ...each, agents: each.agents.filter((agent) => !watching.has(agent)) }));
  return { ...why, refused: refused.filter(({ agents }) => agents.length > 0) };
}

function mainText(why: WhyView): string {
  const { agent, coordinator } = why;
  const total = format.price(why.total_s);
  switch (why.kind) {
    case "withdrawn":
      return t("why.withdrawn", { coordinator });
    case "unknown":
      return t("why.unknown", { agent });
    case "recovered":
      return t("why.recovered", { agent, coordinator });
    case "took_over":
      return tookOverText(why);
    case "waiting":
      return joined(why.passed.length === 0 ? t("why.waiting") : vainText(why.passed, coordinator), refusedText(why.refused));
    case "asked":
      return t("why.asked", { agent, total });
    case "leading":
      return why.left === 1 ? t("why.leadingOnly", { agent, total }) : t("why.leading", { agent, total, count: why.left });
    case "only":
      return onlyText(why, total);
    case "tie":
    case "cheapest":
      return comparedText(why, total);
  }
}

function onlyText({ agent, bidders, coordinator, passed, refused }: WhyView, total: string): string {
  if (passed.length > 0) return joined(t("why.onlyLeft", { agent, total, passed: passedText(passed, coordinator) }), refusedText(refused));
  return joined(t(bidders > 1 ? "why.onlyLeast" : "why.only", { agent, total }), refusedText(refused));
}

function comparedText(why: WhyView, total: string): string {
  const { agent, other } = why;
  const someLeft = why.passed.length > 0;
  const names = { agent, other, total, count: someLeft ? why.left : why.bidders, passed: passedText(why.passed, why.coordinator) };
  if (why.kind === "tie") {
    return t(someLeft ? "why.tieLeft" : "why.tie", { ...names, decided: word("why.tie", why.tie_by) });
  }
  const main = t(someLeft ? "why.cheapestLeft" : "why.cheapest", { ...names, by: format.price(why.by_s) });
  return joined(main, why.part === "" ? "" : word("why.part", why.part));
}

function passedText(passed: readonly PassedView[], coordinator: string): string {
  const named = passed.slice(0, PASSED_NAMED).map((each) => {
    const words = { agent: each.agent, answer: answerText(each, coordinator) };
    if (each.less_s === 0) return t("why.passedEqual", words);
    return t("why.passed", { ...words, by: format.price(each.less_s) });
  });
  const rest = passed.length - named.length;
  return named.join("") + (rest > 0 ? n("why.passedMore", rest) : "");
}

function answerText({ answer, taken_for: taken }: PassedView, coordinator: string): string {
  if (taken === "") return word("answer", answer);
  return t(taken === coordinator ? "why.takenForOwn" : "why.takenFor", { coordinator: taken });
}

function vainText(passed: readonly PassedView[], coordinator: string): string {
  const each = passed.slice(0, PASSED_NAMED).map((one) => t("why.vain", { agent: one.agent, answer: answerText(one, coordinator) }));
  const rest = passed.length - each.length;
  return t("why.waitingVain", { answers: each.join("; ") + (rest > 0 ? n("why.passedMore", rest) : "") });
}

function tookOverText(why: WhyView): string {
  const { agent, coordinator, replaced } = why;
  const main = isSilence(why)
    ? t("why.tookOverSilent", { agent, replaced, silence: format.price(why.silent_s) })
    : t("why.tookOver", { agent, replaced, reason: reasonText(why.reason) });
  return joined(main, why.confirmed ? "" : t("why.unconfirmed", { coordinator }));
}

/** How many did not bid, counted by reason. */
function refusedText(refused: readonly RefusedView[]): string {
  const count = refused.reduce((sum, { agents }) => sum + agents.length, 0);
  const first = refused[0];
  if (!first) return "";
  if (count === 1) return t("why.refusedOne", { agent: first.agents[0] ?? "", reason: refusalText(first) });
  if (refused.length === 1) return t("why.refusedAll", { count: format.count(count), reason: refusalText(first) });
  const reasons = refused.map((each) => t("why.refusedBy", { count: format.count(each.agents.length), reason: refusalText(each) }));
  return t("why.refused", { count: format.count(count), reasons: format.list(reasons) });
}

/** What keeps them from all work, without the particulars, which their own lines tell; or why they do not take this. */
function refusalText({ detail, reason }: RefusedView): string {
  return detail === "" ? word("refusal", reason) : (failureText(detail).split(":")[0] ?? "");
}

function anewText(why: WhyView): string {
  const { replaced } = why;
  if (replaced === "" || why.kind === "took_over") return "";
  const reason = isSilence(why)
    ? t("why.anewSilent", { silence: format.price(why.silent_s) })
    : reasonText(why.reason);
  return t("why.anew", { replaced, reason });
}

function roundsText({ kind, radius_m: radiusM, round }: WhyView): string {
  if (round < 2 || WITHOUT_ROUNDS.has(kind)) return "";
  const open = kind === "waiting" || kind === "leading" || kind === "asked";
  if (radiusM === 0) return t(open ? "why.roundNowAll" : "why.roundsAll", { round });
  return t(open ? "why.roundNow" : "why.rounds", { round, radius: format.count(radiusM) });
}

function joined(...sentences: readonly string[]): string {
  return sentences.filter(Boolean).join(" ");
}
