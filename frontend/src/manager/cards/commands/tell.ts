/** Tells vehicles what to do, once each, and keeps their word on it. */
import { signal } from "@preact/signals";
import { commandAtv } from "../../../api/client";
import type { CommandRequest } from "../../../api/types";
import { failureText } from "../../../text/failure";
import { t, word } from "../../../text/manager";
import { problemText } from "../../problem-text";

/** More than anybody looks at. */
const KEPT = 50;

interface Word {
  readonly good: boolean;
  readonly text: string;
}

export const busy = signal(false);
/** The last word of each vehicle that was told something here. */
export const said = signal<ReadonlyMap<string, Word>>(new Map());

/** A stop waits for nothing that is under way. @returns whether the vehicle has done it */
export async function tell(atv: string, command: CommandRequest): Promise<boolean> {
  const isStop = command.kind === "stop";
  if (busy.value && !isStop) return false;
  busy.value = true;
  try {
    const { detail, done, reason } = await commandAtv(atv, command);
    const what = t(`tell.${command.kind as "stop"}`);
    const why = reason === null ? detail : [word("refusal.command", reason), failureText(detail)].filter((each) => each !== "").join(": ");
    keep(atv, done ? { good: true, text: t("tell.done", { id: atv, what }) } : { good: false, text: t("tell.refused", { id: atv, reason: why }) });
    return done;
  } catch (error) {
    keep(atv, { good: false, text: t("tell.failed", { reason: problemText(error) }) });
    return false;
  } finally {
    busy.value = false;
  }
}

function keep(atv: string, what: Word): void {
  const kept = new Map(said.value);
  kept.delete(atv);
  kept.set(atv, what);
  const [oldest] = kept.keys();
  if (kept.size > KEPT && oldest !== undefined) kept.delete(oldest);
  said.value = kept;
}
