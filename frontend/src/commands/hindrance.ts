/** What keeps a command from being given, so that nothing is offered that cannot be done. Pure. */
import type { AtvView, CommandRequest } from "../api/types";

/** What a vehicle may be told. */
export type VehicleKind = CommandRequest["kind"];

export type Hindrance =
  | "offline"
  | "ended"
  | "lost"
  | "not_stopped"
  | "faulty"
  | "acknowledged"
  | "not_acknowledged"
  | "no_help_wanted"
  | "in_service"
  | "sent_to_charge"
  | "out_of_service";

export interface Circumstances {
  /** Frames are coming. */
  readonly connected: boolean;
  /** The session has ended by time. */
  readonly ended: boolean;
  /** Nothing is heard of the vehicle. */
  readonly lost: boolean;
}

type Vehicle = Pick<AtvView, "status" | "problem" | "acknowledged" | "help" | "out_of_service" | "sent_to_charge">;

/** @returns null where the command may be given; a stop always may, whatever its chances */
export function hindranceOf(kind: VehicleKind, atv: Vehicle, around: Circumstances): Hindrance | null {
  if (kind === "stop") return null;
  if (around.ended) return "ended";
  if (!around.connected) return "offline";
  if (around.lost) return "lost";
  return OF_VEHICLE[kind](atv);
}

const OF_VEHICLE: Readonly<Record<Exclude<VehicleKind, "stop">, (atv: Vehicle) => Hindrance | null>> = {
  set_speed: () => null,
  promise: (atv) => (atv.help ? null : "no_help_wanted"),
  take_out: (atv) => (atv.out_of_service ? "out_of_service" : null),
  put_in: (atv) => (atv.out_of_service || atv.sent_to_charge ? null : "in_service"),
  charge: (atv) => (atv.sent_to_charge ? "sent_to_charge" : null),
  hand_over: (atv) => (atv.help ? null : "no_help_wanted"),
  acknowledge: (atv) => {
    if (atv.status !== "stopped") return "not_stopped";
    if (atv.acknowledged) return "acknowledged";
    return atv.problem === "" ? null : "faulty";
  },
  resume: (atv) => {
    if (atv.status !== "stopped") return "not_stopped";
    return atv.acknowledged ? null : "not_acknowledged";
  },
};
