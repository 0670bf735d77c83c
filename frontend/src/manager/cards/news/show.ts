/** What a piece of news is about, in names that people know, and the way there. */
import type { NewsView } from "../../../api/types";
import { choose } from "../../../selection/selection";
import { world } from "../../../stream/stream";
import { format, t } from "../../../text/manager";
import { names, orderName, plant, taskName } from "../../state";
import { go, goToOrder } from "../../views";
import { howText, whereText } from "../closures/closure-text";
import { subjectOf } from "./news";
import type { Called } from "./news-text";

export function showNews(news: NewsView): void {
  if (news.kind === "goal_waits" && news.order !== "") {
    goToOrder(news.order);
    return;
  }
  const known = world.value;
  const subject = known && subjectOf(news, known);
  // The new carrier's card first, then its task below the map.
  if (known?.atvs.has(news.agent)) choose({ kind: "atv", id: news.agent });
  if (subject) choose(subject);
  go("plant");
}

/** As the stream knows them; by their own names where they have left it. */
export const CALLED: Called = {
  goal: (id) => {
    const task = world.value?.tasks.get(id);
    // A goal that has left it is named by its order, which is the beginning of its name.
    if (!task) return taskName(id, [...(world.value?.orders.keys() ?? [])].find((order) => id.startsWith(`${order}-`)) ?? "");
    return t("auction.what", { quantity: format.count(task.quantity), item: names.value(task.item) });
  },
  order: orderName,
  closure: (closure) => ({ where: whereText(closure, plant.value?.areas ?? []), how: howText(closure) }),
};
