/** Which lines connect whom, from the open tasks and the vehicles' links. */
import type { TaskView } from "../../api/types";
import type { Place } from "../../motion/roads";
import type { Line } from "../draw/lines";

/** Who is watched, beside where the line goes. */
export interface Guard extends Line {
  readonly guarded: string;
}

export interface Links {
  /** Carrier and the coordinator that it works for. */
  readonly primary: readonly Line[];
  /** Watcher and the carrier that it watches. */
  readonly secondary: readonly Guard[];
}

interface Watchful {
  readonly atv: string | null;
  readonly machine: string | null;
}

type Find = (id: string) => Place | undefined;

/** Whether somebody carries it, so that somebody may watch. */
export function isCarried(task: TaskView): boolean {
  return task.state === "contracted" && task.kind === "transport";
}

/**
 * @param tasks carried ones
 * @param find where a vehicle or machine is shown
 * @param only the chosen ones; null for everybody
 */
export function watchLinks(tasks: Iterable<TaskView>, find: Find, only: Watchful | null): Links {
  const primary: Line[] = [];
  const secondary: Guard[] = [];
  for (const task of tasks) {
    const own = only === null || task.primary === only.atv || task.coordinator === only.machine;
    if (own) add(primary, find(task.primary), find(task.coordinator));
    // Who is only watching has nothing to do with the machine.
    if (own || task.secondary === only.atv) {
      const from = find(task.secondary);
      const to = find(task.primary);
      if (from && to) secondary.push({ from, to, guarded: task.primary });
    }
  }
  return { primary, secondary };
}

/** From every vehicle on the radio mesh along those that pass its heartbeat on. */
export function meshLinks(
  vehicles: Iterable<{ x: number; y: number; view: { link: string; via: readonly string[] } }>,
  find: Find,
): Line[] {
  const lines: Line[] = [];
  for (const vehicle of vehicles) {
    if (vehicle.view.link !== "mesh") continue;
    let from: Place | undefined = vehicle;
    for (const relay of vehicle.view.via) {
      const to = find(relay);
      add(lines, from, to);
      from = to;
    }
  }
  return lines;
}

function add(lines: Line[], from: Place | undefined, to: Place | undefined): void {
  if (from && to) lines.push({ from, to });
}
