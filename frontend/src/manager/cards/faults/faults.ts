/** Faults that a person may begin from a card, where the factory is simulated. Pure. */
import type { FaultRequest, FaultView } from "../../../api/types";

export const ATV_FAULTS = ["wlan_cut", "radio_cut", "powered_off", "vehicle_broken", "load_shifted", "crashed"] as const;
export const MACHINE_FAULTS = ["powered_off", "machine_broken", "crashed"] as const;

export type FaultKind = (typeof ATV_FAULTS)[number] | (typeof MACHINE_FAULTS)[number];

/** The fault as the gateway wants it: every kind has its own word for whom it is about. */
export function faultOf(kind: FaultKind, agent: string, reason: string): FaultRequest {
  switch (kind) {
    case "vehicle_broken":
      return { kind, atv: agent, reason };
    case "machine_broken":
      return { kind, machine: agent, reason };
    case "load_shifted":
      return { kind, atv: agent };
    default:
      return { kind, agent };
  }
}

/** Those that this agent suffers from at the moment, oldest first. */
export function faultsOf(faults: Iterable<FaultView>, agent: string): FaultView[] {
  return [...faults].filter((fault) => fault.agents.includes(agent)).sort((a, b) => a.began_at_s - b.began_at_s);
}

/** What makes no sense twice. */
export function isOn(faults: readonly FaultView[], kind: string): boolean {
  return faults.some((fault) => fault.kind === kind);
}
