import { useSignal } from "@preact/signals";
import { readmit } from "../../../api/client";
import type { ShutOutView } from "../../../api/types";
import { nowS } from "../../../stream/stream";
import { format, t } from "../../../text/manager";
import { problemText } from "../../problem-text";

interface Props {
  agent: string;
  kind: "atv" | "machine";
  out: ShutOutView;
}

/** Who has shut this one out and why, and the way back. */
export function ShutOutNote({ agent, kind, out }: Props) {
  const busy = useSignal(false);
  const failed = useSignal("");
  const back = async () => {
    busy.value = true;
    failed.value = "";
    try {
      await readmit(agent);
    } catch (error) {
      failed.value = t("shutOut.failed", { reason: problemText(error) });
    } finally {
      busy.value = false;
    }
  };
  return (
    <div class="problem">
      {t("shutOut.note", { by: out.by, reason: out.reason })}
      <small class="line">
        {t("shutOut.since", { at: format.due(out.at_s, nowS.value) })}
        {kind === "atv" && ` ${t("shutOut.staysStopped")}`}
      </small>
      <button type="button" class="button small promise" disabled={busy.value} onClick={() => void back()}>
        {t("shutOut.readmit", { id: agent })}
      </button>
      {failed.value !== "" && (
        <small class="line" role="alert">
          {failed.value}
        </small>
      )}
    </div>
  );
}
