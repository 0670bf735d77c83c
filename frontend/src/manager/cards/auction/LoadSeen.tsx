import { useSignal } from "@preact/signals";
import { Fragment } from "preact";
import { loadSeen } from "../../../api/client";
import type { CommandAnswer, TaskView } from "../../../api/types";
import { isHeld } from "../../../parts/held-task";
import { t, word } from "../../../text/manager";
import { placeOf } from "../../../text/place";
import { problemText } from "../../problem-text";

const SEEN = [[true, "loadSeen.there"], [false, "loadSeen.missing"]] as const;
const SEEN_AT_DOCK = [[false, "loadSeen.inOrder"], [true, "loadSeen.byHand"]] as const;

/** Whoever has looked for a load that was disputed twice, or at a dock where vehicles fail, says what is there; nothing for other transports. */
export function LoadSeen({ task }: { task: TaskView }) {
  const { fails_at, id } = task;
  if (!isHeld(task)) return null;
  const say = async (there: boolean) => await loadSeen(id, { there });
  if (fails_at !== "") return <IsThere ask={t("loadSeen.askDock", { place: placeOf(fails_at) })} answers={SEEN_AT_DOCK} say={say} />;
  return <IsThere ask={t("loadSeen.ask")} say={say} />;
}

interface Asked {
  /** The question. */
  readonly ask: string;
  /** What may be answered: whether the load is there, and the words of that. */
  readonly answers?: typeof SEEN | typeof SEEN_AT_DOCK;
  /** Sends the answer to whoever waits for it. */
  readonly say: (there: boolean) => Promise<CommandAnswer>;
}

/** Whoever has looked for a load of which nobody else can tell says what is there. */
export function IsThere({ ask, answers = SEEN, say: tell }: Asked) {
  const busy = useSignal(false);
  const failed = useSignal("");
  const say = async (there: boolean) => {
    busy.value = true;
    failed.value = "";
    try {
      const { done, reason, text } = await tell(there);
      if (!done) failed.value = t("loadSeen.failed", { reason: reason === null ? text : word("refusal.command", reason) });
    } catch (error) {
      failed.value = t("loadSeen.failed", { reason: problemText(error) });
    } finally {
      busy.value = false;
    }
  };
  return (
    <p class="load-seen">
      {ask}{" "}
      {answers.map(([there, what]) => (
        <Fragment key={String(there)}>
          <button type="button" class="button small" disabled={busy.value} onClick={() => void say(there)}>
            {t(what)}
          </button>{" "}
        </Fragment>
      ))}
      {failed.value !== "" && <small role="alert"> {failed.value}</small>}
    </p>
  );
}
