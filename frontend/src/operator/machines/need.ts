/** What a machine needs of a person. Pure. */
import type { MachineView } from "../../api/types";
import { byId } from "../../plant/places";
import { isLost } from "../../plant/silence";
import type { Moment } from "../cards/need";

export type MachineNeed =
  /** It stands, and nobody has promised to come. */
  | "help"
  /** Somebody is on the way to it. */
  | "coming"
  /** It is put right, and waits for somebody to say so. */
  | "reset"
  /** Nothing is heard of it. */
  | "lost"
  /** A person has taken it out of service. */
  | "out"
  | "well";

export function machineNeedOf(machine: MachineView, { nowS, speed }: Moment): MachineNeed {
  if (machine.out_of_service && machine.problem === "") return "out";
  if (isLost(machine, nowS, speed)) return machine.out_of_service ? "out" : "lost";
  if (machine.problem === "") return "well";
  if (machine.resettable) return "reset";
  return (machine.help?.promised_by ?? "") === "" ? "help" : "coming";
}

/** Those that a card is shown of, the one that has waited longest first: new ones join below. */
export function needingMachines(machines: Iterable<MachineView>, moment: Moment): readonly MachineView[] {
  return [...machines]
    .filter((machine) => machineNeedOf(machine, moment) !== "well")
    .sort((a, b) => sinceS(a) - sinceS(b) || byId(a, b));
}

/** Since when it needs somebody, or is out of service. */
export function sinceS({ out_of_service: out, since_at_s: since }: Pick<MachineView, "out_of_service" | "since_at_s">): number {
  return out?.since_at_s ?? since ?? 0;
}

interface WaitingGoals {
  readonly goals: MachineView["goals"];
  readonly firstAtS: number | null;
}

/** Which of its goals are not made yet, and by when the first of them should be. */
export function waitingGoals({ goals }: Pick<MachineView, "goals">): WaitingGoals {
  const waiting = goals.filter(({ made, quantity }) => made < quantity);
  const times = waiting.flatMap(({ deadline_at_s: atS }) => atS ?? []);
  return { goals: waiting, firstAtS: times.length > 0 ? Math.min(...times) : null };
}

/** How many machines somebody has to do something about. */
export function needsSomebody(machines: Iterable<MachineView>, moment: Moment): number {
  const well: readonly MachineNeed[] = ["well", "out"];
  return [...machines].filter((machine) => !well.includes(machineNeedOf(machine, moment))).length;
}
