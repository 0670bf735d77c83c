/** One selection is one story: the transport, who carries it, who stands by, the machine, the order. Pure. */
import { type Chosen, lastChosen, type Selection, withChosen } from "../../selection/selection";
import type { TaskView } from "../../api/types";
import type { World } from "../../stream/world";
import { isOpen, orderOf, taskOf } from "../cards/auction/auction";

/**
 * All that belongs to what was chosen, as it is now. What nothing belongs to leaves the other cards as they were: a vehicle that
 * is idle has no machine.
 */
export function storyOf(world: World | null, before: Selection, chosen: Chosen): Selection {
  const own = { ...withChosen(before, chosen), standby: null };
  if (chosen.kind === "lane") return { ...before, lane: own.lane };
  const none = { ...own, order: chosen.kind === "order" ? chosen.id : worksFor(world, chosen) };
  if (world === null) return none;
  const task = taskOfStory(world, own);
  if (task === null) return none;
  const carriesOut = task.kind === "transport";
  const machine = carriesOut ? task.coordinator : task.primary;
  const found = {
    ...own,
    order: chosen.kind === "order" ? chosen.id : (orderOf(world, task) ?? worksFor(world, chosen)),
    standby: carriesOut && task.secondary !== "" ? task.secondary : null,
  };
  // Who watches over somebody else's transport stays what was chosen; the story is the transport's.
  const atv = chosen.kind !== "atv" && world.atvs.has(task.primary) ? task.primary : own.atv;
  const isPlace = chosen.kind === "machine" || chosen.kind === "place";
  const place = !isPlace && world.machines.has(machine) ? ({ kind: "machine", id: machine } as const) : own.place;
  return { ...found, atv, place };
}

/** Whether no vehicle or machine of this plant has that name: an old link, or one of another plant. */
export function isUnknown(world: World | null, { id, kind }: Chosen): boolean {
  const known = kind === "atv" ? world?.atvs : kind === "machine" ? world?.machines : undefined;
  return known !== undefined && !known.has(id);
}

/** What is carried or made in it; null where that has ended, but for who has chosen that very one, or its order. */
export function taskOfStory(world: World, story: Selection): TaskView | null {
  const task = taskOf(world, story);
  return task !== null && (story.latest === "task" || story.latest === "order" || isOpen(task)) ? task : null;
}

/** The order that a machine works at now; null for all else. */
function worksFor(world: World | null, { id, kind }: Chosen): string | null {
  const goal = kind === "machine" ? world?.machines.get(id)?.goals[0]?.goal : undefined;
  const task = world?.tasks.get(goal ?? "");
  return world && task ? orderOf(world, task) : null;
}

/** The story as it goes on, where somebody follows it; the same object while nothing has changed. */
export function followed(world: World | null, before: Selection): Selection {
  const chosen = lastChosen(before);
  if (chosen === null) return before;
  const now = storyOf(world, before, chosen);
  const isSame = now.place?.id === before.place?.id && (["atv", "standby", "task", "order"] as const).every((name) => now[name] === before[name]);
  return isSame ? before : now;
}
