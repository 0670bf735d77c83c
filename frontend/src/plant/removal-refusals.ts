/** Why places of a vehicle that was carried away are not free yet. */
import type { AtvView } from "../api/types";

type Removal = NonNullable<AtvView["removal"]>;

export type Refusals = Map<Removal["refused"][number]["reason"], string[]>;

/** Whether all that the vehicle held is free, and the place kept where it is put back, if any. */
function isDone(holds: string[], { freed, kept, node }: Removal): boolean {
  return freed.length > 0 && holds.every((place) => freed.includes(place)) && (node === "" || kept);
}

/** Reason -> who refuses the report for it; nothing once all is done that the report asks for. */
export function refusalsOf({ holds, removal }: Pick<AtvView, "holds" | "removal">): Refusals {
  const refusals: Refusals = new Map();
  if (!removal || isDone(holds, removal)) return refusals;
  const namedFirst = [...removal.refused].sort((one, other) => Number(one.agent === "") - Number(other.agent === ""));
  for (const { agent, reason } of namedFirst) {
    const agents = refusals.get(reason) ?? [];
    if (!agents.includes(agent)) refusals.set(reason, [...agents, agent]);
  }
  return refusals;
}
