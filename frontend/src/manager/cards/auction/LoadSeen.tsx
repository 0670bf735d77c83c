import { useSignal } from "@preact/signals";
import { loadSeen } from "../../../api/client";
import { t, word } from "../../../text/manager";
import { problemText } from "../../problem-text";

/** Whoever has looked for a load that was disputed twice says what is there. */
export function LoadSeen({ task }: { task: string }) {
  const busy = useSignal(false);
  const failed = useSignal("");
  const say = async (there: boolean) => {
    busy.value = true;
    failed.value = "";
    try {
      const { done, reason, text } = await loadSeen(task, { there });
      if (!done) failed.value = t("loadSeen.failed", { reason: reason === null ? text : word("refusal.command", reason) });
    } catch (error) {
      failed.value = t("loadSeen.failed", { reason: problemText(error) });
    } finally {
      busy.value = false;
    }
  };
  return (
    <p class="load-seen">
      {t("loadSeen.ask")}{" "}
      <button type="button" class="button small" disabled={busy.value} onClick={() => void say(true)}>
        {t("loadSeen.there")}
      </button>{" "}
      <button type="button" class="button small" disabled={busy.value} onClick={() => void say(false)}>
        {t("loadSeen.missing")}
      </button>
      {failed.value !== "" && <small role="alert"> {failed.value}</small>}
    </p>
  );
}
