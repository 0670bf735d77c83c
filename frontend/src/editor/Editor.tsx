import { useEffect } from "preact/hooks";
import { LanguageSwitch } from "../parts/LanguageSwitch";
import { ThemeSwitch } from "../parts/ThemeSwitch";
import { format, n, t } from "../text/editor";
import { noteText } from "../text/views/findings/note-text";
import { followKeys, toolName } from "./acts";
import { Canvas } from "./Canvas";
import { differences } from "./model";
import { Checks, PlayPanel, Properties, Tools } from "./Panels";
import { Start } from "./Start";
import * as state from "./state";

export function Editor() {
  useEffect(followKeys, []);
  return (
    <div class="ed-app">
      <header class="top">
        <a class="logo" href="/"><i aria-hidden="true" />Dray</a>
        <nav aria-label={t("nav")}>
          <a href="/">{t("nav.plant")}</a>
          <a href="/editor" aria-current="page">{t("title")}</a>
        </nav>
        <div class="top-right">
          <LanguageSwitch />
          <ThemeSwitch />
        </div>
      </header>
      {state.draft.value ? <Drawing /> : <Start />}
    </div>
  );
}

const VIEWS = ["running", "over", "alone"] as const;

function Drawing() {
  const draft = state.draft.value;
  if (!draft) return null;
  const errors = state.findings.value.filter(({ level }) => level !== "warning").length;
  const { past, future } = state.history.value;
  const { x_m, y_m } = state.cursor.value;
  return (
    <main class="ed-main" id="content" tabIndex={-1}>
      <div class="ed-head">
        <h1>{t("draft", { name: draft.name })}</h1>
        <span class="tag">{n("differences", differences(state.data.value, state.running.value))}</span>
        {errors > 0 && <span class="tag ed-error">{n("errors", errors)}</span>}
        <span class="ed-kept muted" role="status">{t(`kept.${state.kept.value}`, { version: String(draft.version), by: draft.by })}</span>
        <div class="ed-acts">
          <button type="button" class="button" disabled={past.length === 0} onClick={state.undoOne}>{t("undo")}</button>
          <button type="button" class="button" disabled={future.length === 0} onClick={state.redoOne}>{t("redo")}</button>
          <a class="button" href={`/api/plant-drafts/${draft.id}/file`} download>{t("save")}</a>
          <button type="button" class="button" onClick={() => { void state.keepNow().then(() => { state.draft.value = null; location.hash = ""; }); }}>{t("close")}</button>
        </div>
      </div>
      {state.kept.value === "conflict" && (
        <p class="ed-banner" role="alert">{t("conflict")} <button type="button" class="button small" onClick={() => void state.open(draft.id)}>{t("conflict.load")}</button></p>
      )}
      {state.kept.value === "failed" && <p class="ed-banner" role="alert">{t("failed", { reason: state.trouble.value })}</p>}
      <Tools />
      <section class="card ed-middle" aria-label={t("canvas.label")}>
        <div class="ed-bar">
          <div class="ed-views" role="group" aria-label={t("views")}>
            {VIEWS.map((view) => (
              <button key={view} type="button" class="button small" aria-pressed={state.shown.value === view} onClick={() => { state.shown.value = view; }}>{t(`view.${view}`)}</button>
            ))}
          </div>
          <label>{t("grid")}
            <select value={String(state.grid_m.value)} onChange={(event) => { state.grid_m.value = Number(event.currentTarget.value); }}>
              {[0.1, 0.5, 1].map((each) => <option key={each} value={String(each)}>{format.number(each, 1)} m</option>)}
            </select>
          </label>
        </div>
        <Canvas />
        <p class="ed-foot" id="ed-how">
          <b>{toolName(state.tool.value)}:</b> {t(`how.${state.tool.value}`)} · <span class="num">x {format.number(x_m, 1)}, y {format.number(y_m, 1)} m</span>
        </p>
      </section>
      <Properties />
      {draft.notes.length > 0 && (
        <details class="card ed-notes"><summary>{n("notes", draft.notes.length)}</summary>
          <ul>{draft.notes.map((note) => <li key={note.text}>{noteText(note)}</li>)}</ul>
        </details>
      )}
      <Checks />
      <PlayPanel />
    </main>
  );
}
