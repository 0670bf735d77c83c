import { useSignal } from "@preact/signals";
import { useId } from "preact/hooks";
import { shutOut } from "../../../api/client";
import { t } from "../../../text/manager";
import { PopButton } from "../../parts/PopButton";
import { problemText } from "../../problem-text";

/** As much as the gateway takes. */
const REASON_CHARS = 200;

/** A button at the foot of a card: let nobody hear this one any more, for a reason that is written down. */
export function ShutOutMenu({ agent, kind }: { agent: string; kind: "atv" | "machine" }) {
  const reason = useSignal("");
  const busy = useSignal(false);
  const failed = useSignal("");
  const id = useId();
  const send = async (close: () => void) => {
    busy.value = true;
    failed.value = "";
    try {
      await shutOut(agent, reason.value.trim());
      close();
    } catch (error) {
      failed.value = t("shutOut.failed", { reason: problemText(error) });
    } finally {
      busy.value = false;
    }
  };
  const toggle = () => {
    reason.value = failed.value = "";
  };
  return (
    <PopButton icon="shutOut" label={t("shutOut.open")} title={t(`shutOut.hint.${kind}`, { id: agent })} onToggle={toggle}>
      {(close) => (
        <form
          class="shut-out"
          onSubmit={(event) => {
            event.preventDefault();
            if (reason.value.trim() !== "" && !busy.value) void send(close);
          }}
        >
          <p>{t(`shutOut.hint.${kind}`, { id: agent })}</p>
          <div class="field">
            <label for={id}>{t("shutOut.reason")}</label>
            <input
              autoFocus
              id={id}
              required
              autoComplete="off"
              maxLength={REASON_CHARS}
              value={reason.value}
              onInput={(event) => {
                reason.value = event.currentTarget.value;
              }}
            />
          </div>
          {failed.value !== "" && (
            <p class="complaint" role="alert">
              {failed.value}
            </p>
          )}
          <div class="form-actions">
            <button type="button" class="button" onClick={close}>
              {t("shutOut.keep")}
            </button>
            <button type="submit" class="button primary" disabled={busy.value || reason.value.trim() === ""}>
              {t("shutOut.do", { id: agent })}
            </button>
          </div>
        </form>
      )}
    </PopButton>
  );
}
