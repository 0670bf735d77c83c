import { asksText, whatText } from "../../alerts/alert-text";
import { isOpen } from "../../alerts/alerts";
import type { AlertView } from "../../api/types";
import { Table } from "../../parts/Table";
import { Tag } from "../../parts/Tag";
import { nowS, world } from "../../stream/stream";
import { format, t } from "../../text/manager";
import { NewsList } from "../cards/news/NewsList";
import { alerts } from "../state";
import { AwaitedActions } from "./AwaitedActions";
import { showSubject, subjectOf } from "./subject";
import { failed } from "./take";
import { TakeButton } from "./TakeButton";

/** The inbox: all that is wrong now, who has taken it on, and what has happened lately. */
export function AlertsView() {
  const heads = ["subject", "problem", "response", "since", "takenBy"] as const;
  return (
    <Table
      title={t("alerts.title")}
      heads={heads.map((head) => t(`alerts.${head}`))}
      empty={t("alerts.quiet")}
      aside={failed.value !== "" && <span class="complaint" role="alert">{failed.value}</span>}
      below={<NewsList />}
    >
      {alerts.value.map((alert) => (
        <Row key={alert.id} alert={alert} />
      ))}
    </Table>
  );
}

function Row({ alert }: { alert: AlertView }) {
  const what = whatText(alert, nowS.value, world.value?.factory.speed ?? 1);
  const open = isOpen(alert);
  return (
    <tr class={open ? "" : "closed"}>
      <th scope="row">
        <button type="button" class="link" aria-label={t("alerts.show", { subject: subjectOf(alert) })} onClick={() => { showSubject(alert); }}>
          {subjectOf(alert)}
        </button>
      </th>
      <td>
        <Tag tone={alert.level === "alarm" ? "alarm" : "warn"}>{t(`alerts.kind.${alert.level}`)}</Tag> {what}
      </td>
      <td>
        {asksText(alert)} {alert.kind === "atv_awaited" && <AwaitedActions atv={alert.agent} />}
      </td>
      <td class="num">{format.due(alert.since_at_s, nowS.value)}</td>
      <td>
        {open ? (
          <TakeButton alert={alert} what={what} />
        ) : (
          t("alerts.taken", { by: alert.acknowledged_by, at: format.due(alert.acknowledged_at_s ?? nowS.value, nowS.value) })
        )}
      </td>
    </tr>
  );
}
