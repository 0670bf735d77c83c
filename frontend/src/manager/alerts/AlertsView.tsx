import { asksText, whatText } from "../../alerts/alert-text";
import { isOpen } from "../../alerts/alerts";
import type { AlertView } from "../../api/types";
import { CutOff } from "../../parts/Carrying";
import { Table } from "../../parts/Table";
import { Tag } from "../../parts/Tag";
import { nowS, world } from "../../stream/stream";
import { speakAlso } from "../../text/speech";
import { format, t, tables } from "../../text/views/alerts";
import { NewsList } from "../cards/news/NewsList";
import { alerts } from "../state";
import { ShutOutMenu } from "../cards/agents/ShutOutMenu";
import { MomentLink } from "../replay/MomentLink";
import { AwaitedActions } from "./AwaitedActions";
import { AlertLog } from "./history/AlertLog";
import { SayMenu } from "./SayMenu";
import { subjectOf } from "./subject";
import { SubjectLink } from "./SubjectLink";
import { failed } from "./take";
import { TakeButton } from "./TakeButton";

/** The view, once it has its words. */
export async function load(): Promise<typeof AlertsView> {
  await speakAlso(tables);
  return AlertsView;
}

/** The inbox: all that is wrong now, who has taken it on, and what has happened lately. */
export function AlertsView() {
  const heads = ["subject", "problem", "response", "since", "takenBy"] as const;
  return (
    <Table
      title={t("alerts.title")}
      heads={heads.map((head) => t(`alerts.${head}`))}
      empty={t("alerts.quiet")}
      aside={failed.value !== "" && <span class="complaint" role="alert">{failed.value}</span>}
      note={alerts.value.some(isOfUnheard) && <CutOff class="table-hint" />}
      below={<><AlertLog /><NewsList /></>}
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
        <SubjectLink alert={alert} />
      </th>
      <td>
        <Tag tone={alert.level === "alarm" ? "alarm" : "warn"}>{t(`alerts.kind.${alert.level}`)}</Tag> {what}
      </td>
      <td>
        {asksText(alert)} {isOfUnheard(alert) && <AwaitedActions atv={alert.agent} />}{" "}
        {alert.kind === "atv_unheard" && <ShutOutMenu agent={alert.agent} kind="atv" />}
        {alert.goods !== null && alert.by !== "" && <span class="muted">{t("alerts.goods.by", { by: alert.by })}</span>}{" "}
        {alert.goods !== null && (
          <a class="quiet-link" href={`/operator#goods-${encodeURIComponent(alert.task)}`}>
            {t("alerts.goods.open")}
          </a>
        )}
      </td>
      <td class="num">
        {format.due(alert.since_at_s, nowS.value)} <MomentLink atS={alert.since_at_s} about={subjectOf(alert)} />
      </td>
      <td>
        {open ? <TakeButton alert={alert} what={what} /> : takenText(alert, nowS.value)}{" "}
        <SayMenu alert={alert} what={what} />
        {alert.came_back !== null && <small class="line tone-warn">{t(`alerts.back.${alert.came_back}`)}</small>}
        {alert.comment !== "" && <small class="line muted">{t("alerts.said", { by: alert.comment_by, comment: alert.comment })}</small>}
      </td>
    </tr>
  );
}

/** Whether it can be said here that the vehicle is off the floor. */
function isOfUnheard({ kind }: AlertView): boolean {
  return kind === "atv_awaited" || kind === "atv_unheard";
}

function takenText({ acknowledged_at_s: atS, acknowledged_by: by, acknowledged_until_at_s: untilS }: AlertView, now: number): string {
  const taken = t("alerts.taken", { by, at: format.due(atS ?? now, now) });
  return untilS === null ? taken : `${taken}, ${t("alerts.takenUntil", { at: format.due(untilS, now) })}`;
}
