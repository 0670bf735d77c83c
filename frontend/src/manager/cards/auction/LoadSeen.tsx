import { useSignal } from "@preact/signals";
import { Fragment } from "preact";
import { loadSeen } from "../../../api/client";
import type { TaskView } from "../../../api/types";
import { isHeld } from "../../../parts/held-task";
import { t, word } from "../../../text/manager";
import { placeOf } from "../../../text/place";
import { problemText } from "../../problem-text";

const SEEN = [[true, "loadSeen.there"], [false, "loadSeen.missing"]] as const;
const SEEN_AT_DOCK = [[false, "loadSeen.inOrder"], [true, "loadSeen.byHand"]] as const;

/** Whoever has looked for a load that was disputed twice, or at a dock where vehicles fail, says what is there; nothing for other transports. */
export function LoadSeen({ task }: { task: TaskView }) {
  const { fails_at, id } = task;
  const busy = useSignal(false);
  const failed = useSignal("");
  const say = async (there: boolean) => {
    busy.value = true;
    failed.value = "";
    try {
      const { done, reason, text } = await loadSeen(id, { there });
      if (!done) failed.value = t("loadSeen.failed", { reason: reason === null ? text : word("refusal.command", reason) });
    } catch (error) {
      failed.value = t("loadSeen.failed", { reason: problemText(error) });
    } finally {
      busy.value = false;
    }
  };
  if (!isHeld(task)) return null;
  const answers = fails_at === "" ? SEEN : SEEN_AT_DOCK;
  return (
    <p class="load-seen">
      {fails_at === "" ? t("loadSeen.ask") : t("loadSeen.askDock", { place: placeOf(fails_at) })}{" "}
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
