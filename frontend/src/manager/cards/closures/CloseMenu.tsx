import { useSignal } from "@preact/signals";
import { useId } from "preact/hooks";
import { closeFloor, previewClosure } from "../../../api/client";
import { fieldsAfterSent } from "../../../parts/sent";
import { laneOf } from "../../../plant/surface/lanes";
import { NOTHING_DRAWN, outline, shapeOf } from "../../../selection/outline";
import { selection } from "../../../selection/selection";
import { t } from "../../../text/manager";
import { PopButton } from "../../parts/PopButton";
import { problemText } from "../../problem-text";
import { plant } from "../../state";
import { type Draft, DRAWN, requestOf, warningsOf } from "./closure-text";

/** As much as the gateway takes. */
const REASON_CHARS = 200;
const EMPTY: Draft = { what: "", kind: "closed", speed: "0.5", until: "", reason: "" };

/** Closes what is chosen or drawn on the map, or an area: now, for a reason, and until a time if there is one. */
export function CloseMenu() {
  const draft = useSignal(EMPTY);
  const busy = useSignal(false);
  const failed = useSignal("");
  /** What was said to be lost; asked once, then it is meant. */
  const warned = useSignal<string[]>([]);
  const id = useId();
  const choices = choicesNow();
  const change = (part: Partial<Draft>) => {
    draft.value = { ...draft.value, ...part };
    warned.value = [];
    failed.value = "";
  };
  const wanted = (): Draft => ({ ...draft.value, what: draft.value.what || (choices[0]?.value ?? "") });
  const send = async (close: () => void) => {
    const request = requestOf(wanted(), shapeOf(outline.value.corners));
    if (!request || busy.value) return;
    const sent = draft.value;
    busy.value = true;
    failed.value = "";
    try {
      const warnings = warned.value.length > 0 ? [] : warningsOf(await previewClosure(request));
      if (warnings.length > 0) {
        warned.value = warnings;
        return;
      }
      await closeFloor(request);
      if (request.outline) outline.value = NOTHING_DRAWN;
      if (draft.value === sent) close();
      else change(fieldsAfterSent(sent, draft.value, EMPTY));
    } catch (error) {
      failed.value = t("closures.failed", { reason: problemText(error) });
    } finally {
      busy.value = false;
    }
  };
  const onToggle = (open: boolean) => {
    if (open && outline.value.drawing) outline.value = { ...outline.value, drawing: false };
    if (!open) change(EMPTY);
  };
  const { kind, reason, speed, until, what } = wanted();
  const lane = what.startsWith("lane:") ? laneOf(what.slice(5)) : null;
  return (
    <PopButton icon="shutOut" label={t("closures.open")} title={t("closures.hint")} onToggle={onToggle}>
      {(close) => (
        <form
          class="shut-out close-floor"
          onSubmit={(event) => {
            event.preventDefault();
            void send(close);
          }}
        >
          <p>{t("closures.hint")}</p>
          <p>
            <button
              type="button"
              class="button small"
              onClick={() => {
                outline.value = { drawing: true, corners: [] };
                close();
              }}
            >
              {t("closures.draw")}
            </button>
          </p>
          <div class="field">
            <label for={`${id}-what`}>{t("closures.what")}</label>
            <select id={`${id}-what`} required value={what} onChange={(event) => { change({ what: event.currentTarget.value, kind: "closed" }); }}>
              {choices.map(({ label, value }) => <option key={value} value={value}>{label}</option>)}
            </select>
          </div>
          <div class="field">
            <label for={`${id}-kind`}>{t("closures.how")}</label>
            <select id={`${id}-kind`} value={kind} onChange={(event) => { change({ kind: event.currentTarget.value as Draft["kind"] }); }}>
              <option value="closed">{t("closures.kind.closed")}</option>
              <option value="slow">{t("closures.kind.slow")}</option>
              {lane && <option value="one_way">{t("closures.oneWay", { start: lane.start, end: lane.end })}</option>}
              {lane && <option value="one_way_back">{t("closures.oneWay", { start: lane.end, end: lane.start })}</option>}
            </select>
          </div>
          {kind === "slow" && (
            <div class="field">
              <label for={`${id}-speed`}>{t("closures.speed")}</label>
              <input id={`${id}-speed`} type="number" min="0.1" max="5" step="0.1" required value={speed} onInput={(event) => { change({ speed: event.currentTarget.value }); }} />
            </div>
          )}
          <div class="field">
            <label for={`${id}-until`}>{t("closures.until")}</label>
            <input id={`${id}-until`} type="datetime-local" value={until} onInput={(event) => { change({ until: event.currentTarget.value }); }} />
          </div>
          <div class="field">
            <label for={`${id}-reason`}>{t("closures.reason")}</label>
            <input id={`${id}-reason`} required autoComplete="off" maxLength={REASON_CHARS} value={reason} onInput={(event) => { change({ reason: event.currentTarget.value }); }} />
          </div>
          {[...warned.value, ...(failed.value === "" ? [] : [failed.value])].map((words) => (
            <p key={words} class="complaint" role="alert">
              {words}
            </p>
          ))}
          <div class="form-actions">
            <button type="button" class="button" onClick={close}>
              {t("closures.keep")}
            </button>
            <button type="submit" class="button primary" disabled={busy.value || requestOf(wanted(), shapeOf(outline.value.corners)) === null}>
              {t(`${warned.value.length > 0 ? "closures.doAllTheSame" : "closures.do"}.${kind === "one_way_back" ? "one_way" : kind}`)}
            </button>
          </div>
        </form>
      )}
    </PopButton>
  );
}

/** What is chosen on the map comes first. */
function choicesNow(): { value: string; label: string }[] {
  const { lane, place } = selection.value;
  const ends = lane === null ? null : laneOf(lane);
  const { length } = shapeOf(outline.value.corners);
  return [
    ...(length > 0 ? [{ value: DRAWN, label: t("closures.choice.drawn", { corners: length }) }] : []),
    ...(ends ? [{ value: `lane:${lane}`, label: t("closures.choice.lane", ends) }] : []),
    ...(place ? [{ value: `place:${place.id}`, label: t("closures.choice.place", { place: place.id }) }] : []),
    ...(plant.value?.areas ?? []).map(({ id, name }) => ({ value: `area:${id}`, label: t("closures.choice.area", { area: name }) })),
  ];
}
