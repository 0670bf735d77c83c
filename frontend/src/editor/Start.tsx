/** Which draft: one that there is, one of the running plant, or one of a file. */
import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { fileBody } from "../api/file-body";
import { format, t } from "../text/editor";
import { FileField } from "./FileField";
import * as state from "./state";

export function Start() {
  const name = useSignal("");
  const onto = useSignal(false);
  const unit = useSignal("");
  const failed = useSignal("");
  const busy = useSignal(false);
  useEffect(() => {
    void state.loadDrafts();
  }, []);
  const doing = (work: Promise<void>): void => {
    busy.value = true;
    failed.value = "";
    work.catch((error: unknown) => { failed.value = (error as Error).message; }).finally(() => { busy.value = false; });
  };
  return (
    <main class="ed-start" id="content" tabIndex={-1}>
      <section class="card">
        <h1>{t("title")}</h1>
        <p class="muted">{t("start.what")}</p>
        <label>{t("start.name")} <input type="text" maxLength={80} value={name.value} onInput={(event) => { name.value = event.currentTarget.value; }} /></label>
        <button type="button" class="button primary" disabled={busy.value} onClick={() => { doing(state.create(name.value.trim() || t("start.unnamed"))); }}>{t("start.running")}</button>
        <fieldset>
          <legend>{t("start.file")}</legend>
          <label class="ed-check"><input type="checkbox" checked={onto.value} onChange={(event) => { onto.value = event.currentTarget.checked; }} /> {t("start.onto")}</label>
          <label>{t("start.unit")}{" "}
            <select value={unit.value} onChange={(event) => { unit.value = event.currentTarget.value; }}>
              <option value="">{t("start.unitFound")}</option>
              {["m", "cm", "mm"].map((each) => <option key={each} value={each}>{each}</option>)}
            </select>
          </label>
          <FileField label={t("start.choose")} accept=".yaml,.yml,.json,.lif,.xml" disabled={busy.value} onFile={(file) => {
            doing(fileBody(file).then((body) => state.create(name.value.trim() || file.name, { body, name: file.name, unit: unit.value }, onto.value)));
          }} />
        </fieldset>
        {failed.value && <p role="alert" class="complaint">{failed.value}</p>}
      </section>
      <section class="card" aria-labelledby="ed-drafts">
        <h2 id="ed-drafts">{t("start.drafts")}</h2>
        {state.drafts.value?.length === 0 && <p class="empty">{t("start.none")}</p>}
        <ul class="ed-list">
          {state.drafts.value?.map((draft) => (
            <li key={draft.id}>
              <button type="button" class="button" onClick={() => { doing(state.open(draft.id)); }}>{draft.name}</button>
              <span class="muted">{t("start.by", { by: draft.by, at: format.when(draft.at_s, Date.now() / 1000) })}</span>
              <button type="button" class="button small" aria-label={t("start.removeOf", { name: draft.name })} onClick={() => { doing(state.remove(draft.id)); }}>{t("remove")}</button>
            </li>
          ))}
        </ul>
      </section>
    </main>
  );
}
