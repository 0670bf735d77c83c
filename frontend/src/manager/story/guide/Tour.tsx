import { useEffect } from "preact/hooks";
import { speakAlso } from "../../../text/speech";
import { t, tables } from "../../../text/views/guide";
import { goOn, skip, step, STEPS } from "../tour";

const NARROW_PX = 980;
/** What each step tells of. */
const PARTS: Readonly<Record<number, string>> = { 1: ".map", 2: ".auction", 3: ".top" };

/** The tour, once it has its words. */
export async function load(): Promise<typeof Tour> {
  await speakAlso(tables);
  return Tour;
}

/** One step of the tour, over the part that it tells of. It asks for nothing, and can be left at any step. */
export function Tour() {
  const now = step.value;
  useEffect(() => {
    // Where one thing stands under another, what is told of comes into sight.
    if (innerWidth < NARROW_PX) document.querySelector(PARTS[now] ?? "html")?.scrollIntoView({ block: "start" });
  }, [now]);
  if (now === 0) return null;
  const name = String(now) as "1" | "2" | "3";
  return (
    <aside class="tour card" aria-label={t("tour.label")}>
      <p class="muted">{t("tour.step", { step: now, of: STEPS })}</p>
      <p role="status"><b>{t(`tour.${name}.head`)}</b> {t(`tour.${name}.text`)}</p>
      <div class="tour-acts">
        <button type="button" class="button small" onClick={skip}>{t("tour.skip")}</button>
        <button type="button" class="button small primary" onClick={goOn}>{t(now < STEPS ? "tour.next" : "tour.end")}</button>
      </div>
    </aside>
  );
}
