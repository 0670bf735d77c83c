/** Leads to what a piece of news is about. */
import type { NewsView } from "../../api/types";
import { choose } from "../../selection/selection";
import { world } from "../../stream/stream";
import { go } from "../views";
import { subjectOf } from "./news";

export function showNews(news: NewsView): void {
  const known = world.value;
  const subject = known && subjectOf(news, known);
  // The new carrier's card first, then its task below the map.
  if (known?.atvs.has(news.agent)) choose({ kind: "atv", id: news.agent });
  if (subject) choose(subject);
  go(news.kind === "goal_waits" && !subject ? "orders" : "plant");
}
