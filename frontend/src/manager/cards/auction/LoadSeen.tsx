import { useSignal } from "@preact/signals";
import { loadSeen } from "../../../api/client";
import type { CommandAnswer } from "../../../api/types";
import { t, word } from "../../../text/manager";
import { problemText } from "../../problem-text";

/** Whoever has looked for a load that was disputed twice says what is there. */
export function LoadSeen({ task }: { task: string }) {
  return <IsThere ask={t("loadSeen.ask")} say={async (there) => await loadSeen(task, { there })} />;
}

interface Asked {
  /** The question. */
  readonly ask: string;
  /** Sends the answer to whoever waits for it. */
  readonly say: (there: boolean) => Promise<CommandAnswer>;
}

/** Whoever has looked for a load of which nobody else can tell says what is there. */
export function IsThere({ ask, say: tell }: Asked) {
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
