/** Which draft: one that there is, one of the running plant, or one of a file. */
import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { fileBody } from "../api/file-body";
import { format, t } from "../text/editor";
import { FileField } from "./FileField";
import { emptyFloor } from "./model";
import * as state from "./state";

export function Start() {
  const name = useSignal("");
  const onto = useSignal(false);
  const unit = useSignal("");
  const [width_m, height_m] = [useSignal(40), useSignal(25)];
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
          <legend>{t("start.empty")}</legend>
          <label>{t("start.width")} <input type="number" min={1} max={1000} value={width_m.value} onInput={(event) => { width_m.value = event.currentTarget.valueAsNumber; }} /></label>
          <label>{t("start.depth")} <input type="number" min={1} max={1000} value={height_m.value} onInput={(event) => { height_m.value = event.currentTarget.valueAsNumber; }} /></label>
          <button type="button" class="button" disabled={busy.value || !(width_m.value >= 1 && height_m.value >= 1)} onClick={() => {
            const called = name.value.trim() || t("start.unnamed");
            doing(state.create(called, { body: { text: emptyFloor(called, width_m.value, height_m.value) }, name: "", unit: "" }));
          }}>{t("start.begin")}</button>
        </fieldset>
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
