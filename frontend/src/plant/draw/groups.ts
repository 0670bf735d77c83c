/** The fleet in groups of one look: each is drawn as one, and whoever matters more lies on top. */
import type { ShownVehicle } from "../../motion/fleet-motion";
import type { Look } from "./vehicles";

export type Groups = Readonly<Record<Look, readonly ShownVehicle[]>>;

/** Drawn in this order, and named in the other: the more urgent, the later. */
export const URGENT_LAST = ["charging", "idle", "normal", "lost", "alarm", "chosen"] as const satisfies readonly Look[];

export function groupsOf(vehicles: readonly ShownVehicle[], lookOf: (vehicle: ShownVehicle) => Look): Groups {
  const groups: Record<Look, ShownVehicle[]> = {
    charging: [], idle: [], normal: [], lost: [], alarm: [], chosen: [],
  };
  for (const vehicle of vehicles) groups[lookOf(vehicle)].push(vehicle);
  return groups;
}
