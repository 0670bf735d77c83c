import { useSignal } from "@preact/signals";
import { useId } from "preact/hooks";
import { acknowledgeAlert } from "../../api/client";
import { isOpen } from "../../alerts/alerts";
import type { AlertView } from "../../api/types";
import { afterSent } from "../../parts/sent";
import { nowS } from "../../stream/stream";
import { t } from "../../text/views/alerts";
import { PopButton } from "../parts/PopButton";
import { problemText } from "../problem-text";
import { me } from "../shell/session";
import { subjectOf } from "./subject";

/** As much as the gateway takes. */
const COMMENT_CHARS = 500;
/** Seconds after which it may ask again. */
const LATER_S = ["900", "3600", "14400", "28800"] as const;

/** Takes an alert on with a comment and until some moment; of one that somebody has, only who has it says until when. */
export function SayMenu({ alert, what }: { alert: AlertView; what: string }) {
  const comment = useSignal("");
  const later = useSignal("");
  const busy = useSignal(false);
  const failed = useSignal("");
  const id = useId();
  const open = isOpen(alert);
  const mine = open || alert.acknowledged_by === me.value?.name;
  const ready = open || comment.value.trim() !== "" || later.value !== "";
  const send = async (close: () => void) => {
    const sent = { comment: comment.value, later: later.value };
    busy.value = true;
    failed.value = "";
    try {
      await acknowledgeAlert(alert.id, comment.value.trim(), mine && later.value !== "" ? nowS.value + Number(later.value) : null);
      comment.value = afterSent(sent.comment, comment.value, "");
      later.value = afterSent(sent.later, later.value, "");
      if (comment.value === "" && later.value === "") close();
    } catch (error) {
      failed.value = t("alerts.takeFailed", { reason: problemText(error) });
    } finally {
      busy.value = false;
    }
  };
  const toggle = () => {
    comment.value = later.value = failed.value = "";
  };
  const about = { subject: subjectOf(alert), what };
  return (
    <PopButton icon="down" label={t(open ? "alerts.say" : "alerts.again")} title={t(open ? "alerts.sayOf" : "alerts.againOf", about)} onToggle={toggle}>
      {(close) => (
        <form
          class="say-alert"
          aria-label={t(open ? "alerts.sayOf" : "alerts.againOf", about)}
          onSubmit={(event) => {
            event.preventDefault();
            if (ready && !busy.value) void send(close);
          }}
        >
          <div class="field">
            <label for={id}>{t("alerts.comment")}</label>
            <input autoFocus id={id} autoComplete="off" maxLength={COMMENT_CHARS} value={comment.value} onInput={(event) => { comment.value = event.currentTarget.value; }} />
          </div>
          {mine && (
            <div class="field">
              <label for={`${id}-until`}>{t("alerts.until")}</label>
              <select id={`${id}-until`} value={later.value} onChange={(event) => { later.value = event.currentTarget.value; }}>
                <option value="">{t("alerts.until.end")}</option>
                {LATER_S.map((each) => (
                  <option key={each} value={each}>{t(`alerts.until.${each}`)}</option>
                ))}
              </select>
              <small class="muted">{t("alerts.untilHint")}</small>
            </div>
          )}
          {failed.value !== "" && <p class="complaint" role="alert">{failed.value}</p>}
          <div class="form-actions">
            <button type="submit" class="button primary" disabled={busy.value || !ready}>{t(mine ? "alerts.sayDo" : "alerts.addDo")}</button>
          </div>
        </form>
      )}
    </PopButton>
  );
}
