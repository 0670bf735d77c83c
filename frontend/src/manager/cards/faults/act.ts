/** Begins and ends faults, and keeps what went wrong with the asking. */
import { signal } from "@preact/signals";
import { beginFault, endFault } from "../../../api/client";
import { t } from "../../../text/views/faults";
import { problemText } from "../../problem-text";
import { type Ends, faultOf, type FaultKind, LANE, type Thing } from "./faults";

export const busy = signal(false);
/** Why the last wish was not done, and for whom it was. */
export const failed = signal<{ agent: string; text: string } | null>(null);

export async function begin(kind: FaultKind, agent: string): Promise<void> {
  await run(agent, () => beginFault(faultOf(kind, agent, t("fault.reason"))));
}

export async function beginOnLane({ end: to, start }: Ends, thing: Thing): Promise<void> {
  await run(LANE, () => beginFault({ kind: "lane_blocked", start, end: to, thing }));
}

export async function failDoor(door: string): Promise<void> {
  await run(LANE, () => beginFault({ kind: "door_failed", door }));
}

export async function end(fault: string, agent: string): Promise<void> {
  await run(agent, () => endFault(fault));
}

async function run(agent: string, what: () => Promise<void>): Promise<void> {
  if (busy.value) return;
  busy.value = true;
  failed.value = null;
  try {
    await what();
  } catch (error) {
    failed.value = { agent, text: t("fault.failed", { reason: problemText(error) }) };
  } finally {
    busy.value = false;
  }
}
