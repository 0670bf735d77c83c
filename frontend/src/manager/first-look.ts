/** What is shown before anybody has chosen: a transport that several have bid for, so that the panel explains itself. */
import { effect } from "@preact/signals";
import type { TaskView } from "../api/types";
import { choose, NOTHING, selection } from "../selection/selection";
import { world } from "../stream/stream";
import type { World } from "../stream/world";
import { latestBids, newest } from "./cards/auction/auction";
import { asked } from "./views";

export function chooseAtFirst(): void {
  const stop = effect(() => {
    const known = world.value;
    if (selection.value !== NOTHING || asked.value.at !== undefined) {
      queueMicrotask(() => {
        stop();
      });
      return;
    }
    const first = known && firstLook(known);
    if (first) choose({ kind: "atv", id: first.atv });
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
  return { atv: task.primary, place: { kind: "machine", id: task.coordinator } as const };
}

function bidders(task: TaskView): number {
  return latestBids(task.bids).length;
}
