/**
 * Keeps the customer's page up to date: asks for the same page again and puts its new parts in place, so
 * that the server alone decides what is said, and in which language. Without it the page is whole too.
 */
import "@fontsource-variable/inter/wght.css";
import "../styles/tokens.css";
import "./page.css";
import { isOffline, pauseS, withTime, zoneCookie } from "./pace";

/** An answer takes milliseconds; one that takes this long will not come. */
const PATIENCE_MS = 10_000;

/** 404 and 410: the link has ended, and the server has a page for that. */
const ENDED = new Set([404, 410]);

let tag = "";
let failures = 0;
let timer: ReturnType<typeof setTimeout> | undefined;
let asking = false;
let asOf = clock();

function clock(): string {
  const form = { day: "numeric", month: "short", year: "numeric", hour: "2-digit", minute: "2-digit", hourCycle: "h23" } as const;
  const { lang } = document.documentElement;
  // A bare "en" would write dates the American way.
  return new Intl.DateTimeFormat(lang === "en" ? "en-GB" : lang, form).format(new Date());
}

function byId(id: string, where: Document = document): HTMLElement | null {
  return where.getElementById(id);
}

function say(id: string, sentence: string): void {
  const place = byId(id);
  // Setting the same text again would make a screen reader say it again.
  if (place && place.textContent !== sentence) place.textContent = sentence;
}

function show(text: string): void {
  const fresh = new DOMParser().parseFromString(text, "text/html");
  const [now, next] = [byId("order"), byId("order", fresh)];
  if (!now || !next) return;
  const changed = now.dataset.said !== next.dataset.said;
  document.title = fresh.title;
  for (const { name, value } of next.attributes) now.setAttribute(name, value);
  now.replaceChildren(...next.childNodes);
  say("zone", byId("zone", fresh)?.textContent ?? "");
  if (changed) say("said", next.dataset.said ?? "");
}

/** @returns whether there is nothing more to ask */
async function ask(): Promise<boolean> {
  const answer = await fetch(location.href, {
    headers: tag === "" ? {} : { "If-None-Match": tag },
    cache: "no-store",
    signal: AbortSignal.timeout(PATIENCE_MS),
  });
  if (ENDED.has(answer.status)) {
    location.reload();
    return true;
  }
  if (answer.status !== 304) {
    if (!answer.ok) throw new Error(`the server answered ${answer.status}`);
    show(await answer.text());
    tag = answer.headers.get("ETag") ?? "";
  }
  asOf = clock();
  return false;
}

async function refresh(): Promise<void> {
  if (asking) return;
  asking = true;
  clearTimeout(timer);
  let over = false;
  try {
    over = await ask();
    failures = 0;
  } catch {
    failures += 1;
  }
  asking = false;
  say("as-of", withTime(byId("as-of")?.dataset.text ?? "", asOf));
  say("offline", isOffline(failures) ? withTime(byId("offline")?.dataset.text ?? "", asOf) : "");
  if (!over) schedule();
}

function schedule(): void {
  clearTimeout(timer);
  const order = byId("order");
  // A page that nobody sees asks nothing, and one that has ended tells nothing new.
  if (!order || document.hidden || (order.dataset.ended !== undefined && failures === 0)) return;
  timer = setTimeout(() => void refresh(), pauseS(Number(order.dataset.pollS), failures) * 1000);
}

function start(): void {
  const order = byId("order");
  if (!order) return;
  document.addEventListener("visibilitychange", () => {
    if (document.hidden) clearTimeout(timer);
    else if (order.dataset.ended === undefined) void refresh();
  });
  addEventListener("online", () => void refresh());
  const zone = Intl.DateTimeFormat().resolvedOptions().timeZone;
  document.cookie = zoneCookie(zone, location.protocol === "https:");
  // The server did not know yet where the reader is.
  if (order.dataset.zone !== zone) void refresh();
  else schedule();
}

start();
