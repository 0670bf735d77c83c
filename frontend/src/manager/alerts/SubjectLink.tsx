import type { AlertView } from "../../api/types";
import { t } from "../../text/manager";
import { addressOf } from "../views";
import { orderOf, showSubject, subjectOf } from "./subject";

/** Whom an alert is about, and the way there: an order has a page, all else is on the plant. */
export function SubjectLink({ alert }: { alert: AlertView }) {
  const order = orderOf(alert);
  const subject = subjectOf(alert);
  const label = t("alerts.show", { subject });
  if (order !== "") {
    return (
      <a class="link" href={addressOf(order)} aria-label={label}>
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
