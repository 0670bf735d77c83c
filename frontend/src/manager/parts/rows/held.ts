/** What held up a carrier that was late, as the gateway names it. Pure. */
const OF_VEHICLES = ["waits", "stopped", "blocked", "silent", "charges", "out"] as const;
const OF_MACHINES = ["starves", "broken", "silent", "out"] as const;

export type HeldKey = (typeof OF_VEHICLES)[number] | "waitsFor";
export type MachineHeldKey = (typeof OF_MACHINES)[number] | "starvesFor" | "notFetched";

/** The name in the catalogue of what held a vehicle up; null for nothing, and for what this version does not know. */
export function heldKey(doing: string, by: string): HeldKey | null {
  if (doing === "waits" && by !== "") return "waitsFor";
  return OF_VEHICLES.find((each) => each === doing) ?? null;
}

/** The same of a machine: `blocked` is one whose goods nobody fetches. */
export function machineHeldKey(doing: string, by: string): MachineHeldKey | null {
  if (doing === "starves" && by !== "") return "starvesFor";
  if (doing === "blocked") return "notFetched";
  return OF_MACHINES.find((each) => each === doing) ?? null;
}
