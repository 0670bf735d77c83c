import { whatText, asksText } from "../../alerts/alert-text";
import { isOpen } from "../../alerts/alerts";
import type { AlertView } from "../../api/types";
import { nowS, world } from "../../stream/stream";
import { format, n, t } from "../../text/manager";
import { alerts } from "../state";
import { SubjectLink } from "./SubjectLink";
import { failed } from "./take";
import { TakeButton } from "./TakeButton";

/** More than fit; the view of all of them is one click away. */
const MOST = 20;

/** What nobody has taken on yet. Not there when there is nothing: the factory then needs nobody. */
export function AlertsCard() {
  const open = alerts.value.filter(isOpen);
  if (open.length === 0) return null;
  return (
    <section class="card inbox" aria-labelledby="inbox">
      <header class="card-head">
        <h2 id="inbox">{t("alerts.open")}</h2>
        <WayToClosures />
        <a class="quiet-link card-aside" href="#alerts">
          {t("alerts.all", { count: format.count(alerts.value.length) })}
        </a>
      </header>
      {failed.value !== "" && (
        <p class="complaint" role="alert">
          {failed.value}
        </p>
      )}
      <ul class="inbox-list">
        {open.slice(0, MOST).map((alert) => (
          <Line key={alert.id} alert={alert} />
        ))}
      </ul>
      {open.length > MOST && <a class="quiet-link" href="#alerts">{n("alerts.more", open.length - MOST)}</a>}
    </section>
  );
}

/** On a low screen this card stands over what is closed: how much that is, and the way to it. */
function WayToClosures() {
  const closed = world.value?.closures.size ?? 0;
  if (closed === 0) return null;
  return (
    <button type="button" class="inbox-closed link" title={t("closures.show")} onClick={showClosures}>
      {t("closures.count", { n: format.count(closed) })}
    </button>
  );
}

/** Whoever comes to what is closed can open it at once. */
function showClosures(): void {
  document.getElementById("closures")?.closest("section")?.querySelector("button")?.focus();
}

function Line({ alert }: { alert: AlertView }) {
  const what = whatText(alert, nowS.value, world.value?.factory.speed ?? 1);
  return (
    <li class={`inbox-line inbox-${alert.level}`}>
      <i aria-hidden="true" />
      <p>
        <span class="unseen">{t(`alerts.kind.${alert.level}`)}: </span>
        <SubjectLink alert={alert} />{" "}
        {what}
      </p>
      <TakeButton alert={alert} what={what} />
      <small class="inbox-asks muted">{asksText(alert)}</small>
    </li>
  );
}
