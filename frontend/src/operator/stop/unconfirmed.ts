/** Which Stops are not confirmed, and so must stay in sight wherever their vehicle goes. Pure. */
import type { AtvView } from "../../api/types";
import { type Command, isUnderway } from "../commands/life";

/** A vehicle near a gateway answers in a tenth of this. */
const PATIENCE_S = 2;

/**
 * The last Stop of each vehicle, unless it is confirmed: by the vehicle's word on it, by its own heartbeat that
 * says that it is stopped, or because it was let go on since. By vehicle, in the order in which they were given.
 *
 * @param seen ids of those that a person has seen to
 */
export function openOf(
  commands: Iterable<Command>,
  atvs: ReadonlyMap<string, Pick<AtvView, "status" | "seen_at_s">>,
  seen: ReadonlySet<string>,
): Map<string, Command> {
  const last = new Map<string, Command>();
  for (const command of commands) {
    const { atS, atv, kind, stage } = command;
    // What was asked in vain after a Stop says nothing about it.
    if (kind !== "stop" && !(kind === "resume" && stage === "confirmed")) continue;
    if (atS >= (last.get(atv)?.atS ?? -Infinity)) last.set(atv, command);
  }
  const open = [...last.values()].filter((command) => isOpen(command, atvs.get(command.atv)) && !seen.has(command.id));
  return new Map(open.sort((a, b) => a.atS - b.atS).map((command) => [command.atv, command]));
}

function isOpen({ atS, kind, stage }: Command, atv: Pick<AtvView, "status" | "seen_at_s"> | undefined): boolean {
  if (kind !== "stop" || stage === "confirmed") return false;
  return !(atv?.status === "stopped" && atv.seen_at_s > atS);
}

/** Whether a person has to be told: it was not confirmed when it should have been. */
export function isWorrying(command: Command, nowS: number): boolean {
  return !isUnderway(command) || nowS - command.atS > PATIENCE_S;
}
