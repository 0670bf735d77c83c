import type { AlertView } from "../../api/types";
import { t } from "../../text/manager";
import { pageOf, showSubject, subjectOf } from "./subject";

/** Whom an alert is about, and the way there: an order and a plain transport have a page, all else is on the plant. */
export function SubjectLink({ alert }: { alert: AlertView }) {
  const page = pageOf(alert);
  const subject = subjectOf(alert);
  const label = t("alerts.show", { subject });
  if (page !== "") {
    return (
      <a class="link" href={page} aria-label={label}>
        {subject}
      </a>
    );
  }
  return (
    <button type="button" class="link" aria-label={label} onClick={() => { showSubject(alert); }}>
      {subject}
    </button>
  );
}
