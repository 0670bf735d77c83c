import { Icon } from "../../parts/Icon";
import { world } from "../../stream/stream";
import { n, t } from "../../text/manager";
import { countsOf } from "../../alerts/alerts";
import { alerts } from "../state";
import { view } from "../views";

/** How much is wrong, wherever one is: what nobody has taken on, and what somebody has, until it ends. */
export function AlertsTag() {
  const { alarms, alarmsTaken, warnings, warningsTaken } = countsOf(alerts.value);
  const open = alarms + warnings;
  return (
    <a class="alerts-button" href="#alerts" aria-current={view.value === "alerts" ? "page" : undefined}>
      {world.value === null && <span class="tag">{t("alerts.title")}</span>}
      {world.value !== null && open + alarmsTaken + warningsTaken === 0 && (
        <span class="tag">
          <Icon name="check" />
          {t("alerts.none")}
        </span>
      )}
      {alarms > 0 && <span class="tag tag-alarm">{n("alerts.alarm", alarms)}</span>}
      {alarms === 0 && alarmsTaken > 0 && <span class="tag">{n("alerts.alarmTaken", alarmsTaken)}</span>}
      {warnings > 0 && <span class="tag tag-warn">{n("alerts.warning", warnings)}</span>}
      {open === 0 && alarmsTaken === 0 && warningsTaken > 0 && <span class="tag">{n("alerts.warningTaken", warningsTaken)}</span>}
    </a>
  );
}
