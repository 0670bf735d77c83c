/** How far a call is: four steps, and the reason where it stays at one. */
import type { TransportAnswer } from "../../api/transports";
import type { BufferView, TaskView } from "../../api/types";

export const STEPS = ["called", "taken", "aboard", "here"] as const;

const AT: Readonly<Record<string, number>> = { waiting: 0, assigned: 1, on_board: 2, delivered: 3 };

/** At which step it is; null for one that was called off. */
export function stepOf(call: TransportAnswer): number | null {
  return AT[call.status] ?? null;
}

/** Who has not bid for a transport, by reason: of each vehicle its newest answer, what holds for most of them first. Those elsewhere have no name, so only the newest of them is told. */
export function unwillingOf(task: Pick<TaskView, "refusals"> | undefined): { reason: string; vehicles: string[] }[] {
  const newest = new Map((task?.refusals ?? []).filter(({ role }) => role === "primary").map(({ agent, reason }) => [agent, reason]));
  const reasons = new Map<string, string[]>();
  for (const [vehicle, reason] of newest) reasons.set(reason, [...(reasons.get(reason) ?? []), vehicle].sort());
  return [...reasons].map(([reason, vehicles]) => ({ reason, vehicles })).sort((a, b) => b.vehicles.length - a.vehicles.length || a.reason.localeCompare(b.reason));
}

/** Whether it can be called off: not once it is on board, and not twice. */
export function canCallOff(call: TransportAnswer): boolean {
  return (call.status === "waiting" || call.status === "assigned") && call.cancel_at === null;
}

/** What has ended is shown for so long. */
const SHOWN_MS = 10 * 60_000;

/** What is under way, and what has ended lately, the newest first. */
export function shownCalls(calls: readonly TransportAnswer[], nowMs: number): TransportAnswer[] {
  return calls.filter(({ ended_at: ended }) => ended === null || nowMs - Date.parse(ended) < SHOWN_MS);
}

/** What vehicles of the plant can carry, what most types carry first. */
export function abilitiesOf(types: readonly { abilities: readonly string[] }[]): string[] {
  const counts = new Map<string, number>();
  for (const each of types.flatMap(({ abilities }) => abilities)) counts.set(each, (counts.get(each) ?? 0) + 1);
  return [...counts].sort(([a, m], [b, n]) => n - m || a.localeCompare(b)).map(([ability]) => ability);
}

export interface Choice {
  readonly item: string;
  readonly way: "bring" | "take";
  /** The same for every try at this choice. */
  readonly key: string;
}

/** How many loads the second touch offers: a pallet more is a transport more. */
export const LOADS = [1, 2] as const;

/** What one load takes away: what is there, and no more than a load. */
export function loadFrom(buffers: readonly Pick<BufferView, "item" | "level">[], item: string, lot: number): number {
  const level = buffers.find((each) => each.item === item)?.level ?? lot;
  return level > 0 ? Math.min(lot, level) : lot;
}

/** One load as it is sent; each has a key of its own, so that none is done twice. */
export function loadOf(choice: Choice, place: string, lot: number, urgent: boolean, load: number) {
  const end = choice.way === "bring" ? { to: place } : { from: place };
  return {
    draft: { ...end, item: choice.item, quantity: lot, priority: urgent ? ("urgent" as const) : ("normal" as const) },
    key: `${choice.key}-${urgent ? "u" : "n"}-${load}`,
  };
}
