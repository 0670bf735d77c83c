/** Faults that a person may begin from a card, where the factory is simulated. Pure. */
import type { FaultRequest, FaultView } from "../../../api/types";

export const ATV_FAULTS = ["wlan_cut", "radio_cut", "powered_off", "vehicle_broken", "load_shifted", "load_dropped", "crashed"] as const;
export const MACHINE_FAULTS = ["powered_off", "machine_broken", "crashed"] as const;

export const KINDS = { atv: ATV_FAULTS, machine: MACHINE_FAULTS } as const;

export type FaultKind = (typeof ATV_FAULTS)[number] | (typeof MACHINE_FAULTS)[number];

/** The fault as the gateway wants it: every kind has its own word for whom it is about. */
export function faultOf(kind: FaultKind, agent: string, reason: string): FaultRequest {
  switch (kind) {
    case "vehicle_broken":
      return { kind, atv: agent, reason };
    case "machine_broken":
      return { kind, machine: agent, reason };
    case "load_shifted":
    case "load_dropped":
      return { kind, atv: agent };
    default:
      return { kind, agent };
  }
}

/** Those that this agent suffers from at the moment, oldest first. */
export function faultsOf(faults: Iterable<FaultView>, agent: string): FaultView[] {
  return [...faults].filter((fault) => fault.agents.includes(agent)).sort((a, b) => a.began_at_s - b.began_at_s);
}

/** Where a complaint about a lane is kept: no agent has such a name. */
export const LANE = "/lane";

export const THINGS = ["pallet", "person", "door"] as const;
export type Thing = (typeof THINGS)[number];

export interface Ends {
  readonly start: string;
  readonly end: string;
}

/** What is in the way on a lane, in either direction, by somebody's hand; also that its door, if it has one, does not open. */
export function onLane(faults: Iterable<FaultView>, { end, start }: Ends, door?: string): FaultView[] {
  return [...faults].filter(({ fault, kind }) => {
    if (kind === "door_failed") return (fault as { door?: string }).door === door;
    const ends = fault as Partial<Ends>;
    return kind === "lane_blocked" && ((ends.start === start && ends.end === end) || (ends.start === end && ends.end === start));
  });
}

/** What makes no sense twice. */
export function isOn(faults: readonly FaultView[], kind: string): boolean {
  return faults.some((fault) => fault.kind === kind);
}
