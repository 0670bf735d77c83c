import { isOpen } from "../../alerts/alerts";
import { Icon } from "../../parts/Icon";
import { n, t } from "../../text/manager";
import { alerts } from "../state";
import { view } from "../views";

/** How much is wrong that nobody has taken on, wherever one is. */
export function AlertsTag() {
  const open = alerts.value.filter(isOpen);
  const alarms = open.filter((alert) => alert.level === "alarm").length;
  const warnings = open.length - alarms;
  return (
    <a class="alerts-button" href="#alerts" aria-current={view.value === "alerts" ? "page" : undefined}>
      {open.length === 0 && (
        <span class="tag">
          <Icon name="check" />
          {t("alerts.none")}
        </span>
      )}
      {alarms > 0 && <span class="tag tag-alarm">{n("alerts.alarm", alarms)}</span>}
      {warnings > 0 && <span class="tag tag-warn">{n("alerts.warning", warnings)}</span>}
    </a>
  );
}
