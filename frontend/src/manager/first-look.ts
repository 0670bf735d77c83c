/** What is shown before anybody has chosen: a transport that several have bid for, so that the panel explains itself. */
import { effect } from "@preact/signals";
import type { TaskView } from "../api/types";
import { NOTHING, selection } from "../selection/selection";
import { world } from "../stream/stream";
import type { World } from "../stream/world";
import { latestBids, newest } from "./cards/auction/auction";

export function chooseAtFirst(): void {
  const stop = effect(() => {
    const known = world.value;
    if (selection.value !== NOTHING) {
      queueMicrotask(() => {
        stop();
      });
      return;
    }
    const first = known && firstLook(known);
    if (first) selection.value = { ...NOTHING, ...first };
  });
}

export function firstLook(world: World) {
  const tasks = [...world.tasks.values()].filter(
    ({ coordinator, primary, state }) =>
      state === "contracted" && world.machines.has(coordinator) && world.atvs.has(primary),
  );
  const most = Math.max(...tasks.map(bidders));
  const task = newest(tasks.filter((each) => bidders(each) === most));
  if (!task) return null;
  return {
    atv: task.primary,
    place: { kind: "machine", id: task.coordinator } as const,
    task: null,
    latest: "atv" as const,
  };
}

function bidders(task: TaskView): number {
  return latestBids(task.bids).length;
}
