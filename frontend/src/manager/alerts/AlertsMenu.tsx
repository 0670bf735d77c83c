import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { choose } from "../../selection/selection";
import { Icon } from "../../parts/Icon";
import { nowS } from "../../stream/stream";
import { format, n, t } from "../../text/manager";
import { NewsList } from "../news/NewsList";
import { alerts } from "../state";
import { go } from "../views";
import type { Alert } from "./alerts";

/** The count of what is wrong, and the list of it on demand. */
export function AlertsMenu() {
  const open = useSignal(false);
  const root = useRef<HTMLDivElement>(null);
  useEffect(() => {
    const close = (event: Event): void => {
      if (event instanceof KeyboardEvent ? event.key === "Escape" : !root.current?.contains(event.target as Node)) {
        open.value = false;
      }
    };
    addEventListener("pointerdown", close);
    addEventListener("keydown", close);
    return () => {
      removeEventListener("pointerdown", close);
      removeEventListener("keydown", close);
    };
  }, [open]);
  const alarms = alerts.value.filter((alert) => alert.level === "alarm").length;
  const warnings = alerts.value.length - alarms;
  return (
    <div class="menu" ref={root}>
      <button
        type="button"
        class="alerts-button"
        aria-expanded={open.value}
        aria-haspopup="true"
        onClick={() => {
          open.value = !open.value;
        }}
      >
        {alerts.value.length === 0 && (
          <span class="tag">
            <Icon name="check" />
            {t("alerts.none")}
          </span>
        )}
        {alarms > 0 && <span class="tag tag-alarm">{n("alerts.alarm", alarms)}</span>}
        {warnings > 0 && <span class="tag tag-warn">{n("alerts.warning", warnings)}</span>}
      </button>
      {open.value && (
        <div class="menu-sheet card">
          <h2>{t("alerts.title")}</h2>
          {alerts.value.length === 0 && <p class="empty">{t("alerts.none")}</p>}
          <ul>
            {alerts.value.map((alert) => (
              <li key={`${alert.reason}${alert.subject}`}>
                <AlertButton
                  alert={alert}
                  done={() => {
                    open.value = false;
                  }}
                />
              </li>
            ))}
          </ul>
          <NewsList
            done={() => {
              open.value = false;
            }}
          />
        </div>
      )}
    </div>
  );
}

function AlertButton({ alert, done }: { alert: Alert; done: () => void }) {
  const show = (): void => {
    if (alert.chosen) choose(alert.chosen);
    go(alert.chosen ? "plant" : "orders");
    done();
  };
  return (
    <button type="button" class={`alert alert-${alert.level}`} onClick={show}>
      <i aria-hidden="true" />
      <b>{alert.subject}</b>
      <span class="faint">{t(`alerts.kind.${alert.level}`)}</span>
      <span class="alert-text">{[reasonText(alert), alert.problem].filter(Boolean).join(": ")}</span>
    </button>
  );
}

function reasonText({ by = "", reason, value }: Alert): string {
  switch (reason) {
    case "machineLost":
      return t("alerts.machineLost", { age: format.age(value) });
    case "atvHelp":
      return value > 0 ? t("alerts.atvHelp", { left: format.duration(value) }) : t("alerts.atvHelpLate");
    case "atvPromised":
      return t("alerts.atvPromised", { by, left: format.duration(Math.max(0, value)) });
    case "atvLost":
      return t("alerts.atvLost", { age: format.age(value) });
    case "atvBattery":
      return t("alerts.atvBattery", { percent: format.percent(value) });
    case "orderLate":
      return t("alerts.orderLate", { due: format.due(value, nowS.value) });
    default:
      return t(`alerts.${reason}`);
  }
}
