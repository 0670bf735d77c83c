/** Tells of what asks for an answer: in the title and icon of the tab, and of new alarms with a sound and a notification, where somebody has asked for that here. */
import { effect, signal } from "@preact/signals";
import { asksText, whatText } from "../../../alerts/alert-text";
import { isOpen } from "../../../alerts/alerts";
import { beginSound, playSound, type SoundRefusal, soundRefusal, soundWanted, wantSound } from "../../../alerts/sound";
import type { AlertView } from "../../../api/types";
import { recall, remember } from "../../../memory";
import { nowS, world } from "../../../stream/stream";
import { t } from "../../../text/manager";
import { alerts } from "../../state";
import { showSubject, subjectOf } from "../subject";

export type Way = "sound" | "notice";
/** Why the browser does not do what it was asked for; empty where it does. */
export type Refusal = SoundRefusal | "denied" | "unanswered" | "cannot";

const NOTICE_KEY = "dray.tell.notice";

export const wanted = { sound: soundWanted, notice: signal(recall(NOTICE_KEY) === "yes") };
export const refusal = { sound: soundRefusal, notice: signal<Refusal>("") };

/** To be called by a click only: browsers take no other asking for an answer. */
export async function want(way: Way, on: boolean): Promise<void> {
  if (way === "sound") {
    await wantSound(on);
    return;
  }
  refusal.notice.value = on ? await askForNotices() : "";
  wanted.notice.value = on && refusal.notice.value === "";
  remember(NOTICE_KEY, wanted.notice.value ? "yes" : "no");
}

async function askForNotices(): Promise<Refusal> {
  if (typeof Notification === "undefined" || !isSecureContext) return "cannot";
  const answer = Notification.permission === "default" ? await Notification.requestPermission() : Notification.permission;
  if (answer === "granted") return "";
  return answer === "denied" ? "denied" : "unanswered";
}

function notify(alert: AlertView): void {
  if (Notification.permission !== "granted") {
    refusal.notice.value = "denied";
    return;
  }
  const title = `${subjectOf(alert)}: ${whatText(alert, nowS.peek(), world.peek()?.factory.speed ?? 1)}`;
  const notice = new Notification(title, { body: asksText(alert), tag: alert.id });
  notice.onclick = () => {
    window.focus();
    showSubject(alert);
    notice.close();
  };
}

/** Alarms that ask now and did not before, and all that ask; what was there when the page was opened is no news. Pure. */
export function newAlarms(before: ReadonlySet<string> | null, shown: readonly AlertView[]): { readonly asking: ReadonlySet<string>; readonly fresh: readonly AlertView[] } {
  const open = shown.filter((alert) => isOpen(alert) && alert.level === "alarm");
  const asking = new Set(open.map(({ id }) => id));
  return { asking, fresh: before === null ? [] : open.filter(({ id }) => !before.has(id)) };
}

/** Begins to tell, as long as the page lasts. */
export function beginToTell(): void {
  let before: ReadonlySet<string> | null = null;
  beginSound();
  if (wanted.notice.value && (typeof Notification === "undefined" || Notification.permission !== "granted")) refusal.notice.value = "denied";
  effect(() => {
    if (world.value === null) return;
    const { asking, fresh } = newAlarms(before, alerts.value);
    before = asking;
    if (fresh.length === 0) return;
    playSound();
    if (wanted.notice.peek() && typeof Notification !== "undefined") fresh.forEach(notify);
  });
}

/** How much asks for an answer, where the page is one of many tabs. */
export function followTitle(): void {
  const icon = document.querySelector<HTMLLinkElement>("link[rel=icon]");
  effect(() => {
    const open = alerts.value.filter(isOpen);
    document.title = open.length === 0 ? t("app.title") : `(${String(open.length)}) ${t("app.title")}`;
    const href = open.some((alert) => alert.level === "alarm") ? "/static/icon-alarm.svg" : "/static/icon.svg";
    if (icon && !icon.href.endsWith(href)) icon.href = href;
  });
}
