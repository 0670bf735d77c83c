/** Which news are shown where, and what to look at for them. Pure. */
import type { NewsView } from "../../../api/types";
import type { Chosen } from "../../../selection/selection";
import type { World } from "../../../stream/world";

/** Long enough to be read twice. */
const FRESH_S = 12;
/** More at once would hide the plant. */
const MOST_STRIPS = 3;
/** As many as a person scrolls through. */
const MOST_LISTED = 20;

/** What a person need not be told at once: good news, what follows other news, what people have done, and what is an alert. */
const QUIET = new Set<NewsView["kind"]>([
  "link_back", "help_promised", "silent", "heard_again", "carried_away", "put_back", "stopped", "closed", "opened",
]);

/** Newest first. */
export function lately(news: Iterable<NewsView>): NewsView[] {
  return [...news].sort((a, b) => b.at_s - a.at_s).slice(0, MOST_LISTED);
}

/** Those that are laid over the map for a while. */
export function strips(news: Iterable<NewsView>, nowS: number, dismissed: ReadonlySet<string>): NewsView[] {
  return lately(news)
    .filter((each) => nowS - each.at_s < FRESH_S && !QUIET.has(each.kind) && !dismissed.has(keyOf(each)))
    .slice(0, MOST_STRIPS);
}

/** The same news told anew is another one. */
export function keyOf(news: NewsView): string {
  return `${news.id} ${news.at_s}`;
}

/** What to choose to see more; null where the plant shows nothing of it. */
export function subjectOf(news: NewsView, world: World): Chosen | null {
  if (world.tasks.has(news.task)) return { kind: "task", id: news.task };
  if (world.atvs.has(news.agent)) return { kind: "atv", id: news.agent };
  if (world.machines.has(news.agent)) return { kind: "machine", id: news.agent };
  return null;
}

/** How grave it is: something was lost or waits for a person, or the plant has helped itself. */
export function toneOf(news: NewsView): "warn" | "chosen" | "normal" {
  switch (news.kind) {
    case "help_asked":
    case "goal_lost":
    case "goal_waits":
    case "memory_lost":
    case "announced_anew":
    case "silent":
      return "warn";
    case "took_over":
      return "chosen";
    default:
      return "normal";
  }
}
