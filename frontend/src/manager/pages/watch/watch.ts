/** Who watches whom: one line for every transport that somebody carries. Pure. */
import type { AtvView, TaskView } from "../../../api/types";
import { isLost, isOverdue } from "../../../plant/silence";
import { byId } from "../../../plant/places";
import type { World } from "../../../stream/world";

export type WatchState = "silent" | "overdue" | "unwatched" | "watched";

export interface Watched {
  readonly task: TaskView;
  /** The carrier, as it was heard last; null where it was never heard. */
  readonly carrier: AtvView | null;
  readonly secondary: AtvView | null;
  readonly state: WatchState;
  /** Goods exist only once: when they are on board, nobody could take over. */
  readonly aboard: boolean;
}

export const FILTERS = ["all", "watched", "unwatched", "overdue"] as const;
export type Filter = (typeof FILTERS)[number];

const RANK: Readonly<Record<WatchState, number>> = { silent: 0, overdue: 1, unwatched: 2, watched: 3 };

/** The worst first, then by carrier: a line keeps its place while nothing happens to it. */
export function watches(world: World, nowS: number): Watched[] {
  const all = [...world.tasks.values()].flatMap((task) => {
    if (task.kind !== "transport" || task.state !== "contracted" || task.primary === "") return [];
    const carrier = world.atvs.get(task.primary) ?? null;
    const secondary = world.atvs.get(task.secondary) ?? null;
    const state = stateOf(task, carrier, nowS, world.factory.speed);
    return [{ task, carrier, secondary, state, aboard: task.goods_aboard }];
  });
  return all.sort((a, b) => RANK[a.state] - RANK[b.state] || byId({ id: a.task.primary }, { id: b.task.primary }));
}

function stateOf(task: TaskView, carrier: AtvView | null, nowS: number, speed: number): WatchState {
  if (carrier && isLost(carrier, nowS, speed)) return "silent";
  if (carrier && isOverdue(carrier, nowS, speed)) return "overdue";
  return task.secondary === "" ? "unwatched" : "watched";
}

/** Whether its carrier may have failed and nobody is there to take over. While the carrier is heard, nothing is wrong without a watch. */
export function isExposed({ aboard, state, task }: Watched): boolean {
  return (state === "silent" || state === "overdue") && task.secondary === "" && !aboard;
}

export function passes({ state, task }: Watched, filter: Filter): boolean {
  switch (filter) {
    case "all":
      return true;
    case "watched":
      return task.secondary !== "";
    case "unwatched":
      return task.secondary === "";
    case "overdue":
      return state === "overdue" || state === "silent";
  }
}

/** @param words part of the name of a vehicle, a machine or a task */
export function isFound({ task }: Watched, words: string): boolean {
  const names = `${task.id} ${task.primary} ${task.secondary} ${task.coordinator}`.toLowerCase();
  return names.includes(words.trim().toLowerCase());
}
