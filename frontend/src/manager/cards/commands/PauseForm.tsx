import { useSignal } from "@preact/signals";
import { useId } from "preact/hooks";
import { letAreaGoOn, pauseArea } from "../../../api/client";
import type { PauseAnswer } from "../../../api/types";
import { world } from "../../../stream/stream";
import { t } from "../../../text/manager";
import { problemText } from "../../problem-text";
import { plant } from "../../state";

/** As much as the gateway takes. */
const REASON_CHARS = 200;

/** Pauses an area: nobody drives into it, and whoever is in it stands, until it is let go on. */
export function PauseForm() {
  const chosen = useSignal("");
  const reason = useSignal("");
  const busy = useSignal(false);
  const said = useSignal<readonly string[]>([]);
  const id = useId();
  const areas = plant.value?.areas ?? [];
  const area = chosen.value || (areas[0]?.id ?? "");
  const closed = [...(world.value?.closures.values() ?? [])].some((each) => each.area === area && each.kind === "closed");
  const act = async (what: () => Promise<PauseAnswer>, done: (count: number) => string) => {
    if (busy.value) return;
    busy.value = true;
    said.value = [];
    try {
      const { vehicles } = await what();
      const left = vehicles.filter((each) => !each.done);
      said.value = [done(vehicles.length - left.length), ...left.map(({ atv, text }) => t("pause.left", { id: atv, reason: text }))];
    } catch (error) {
      said.value = [t("tell.failed", { reason: problemText(error) })];
    } finally {
      busy.value = false;
    }
  };
  return (
    <form
      class="shut-out pause-area"
      onSubmit={(event) => {
        event.preventDefault();
        void act(() => pauseArea(area, reason.value.trim()), (count) => t("pause.paused", { count }));
      }}
    >
      <p>{t("pause.hint")}</p>
      <div class="field">
        <label for={`${id}-area`}>{t("pause.area")}</label>
        <select id={`${id}-area`} value={area} onChange={(event) => { chosen.value = event.currentTarget.value; said.value = []; }}>
          {areas.map(({ id: each, name }) => <option key={each} value={each}>{name}</option>)}
        </select>
      </div>
      <div class="field">
        <label for={`${id}-reason`}>{t("tell.reason")}</label>
        <input id={`${id}-reason`} required autoComplete="off" maxLength={REASON_CHARS} value={reason.value} onInput={(event) => { reason.value = event.currentTarget.value; }} />
      </div>
      <div class="outcome" role="status">
        {said.value.map((words) => <p key={words}>{words}</p>)}
      </div>
      <div class="form-actions">
        <button type="button" class="button" disabled={busy.value || !closed} onClick={() => void act(() => letAreaGoOn(area), (count) => t("pause.goesOn", { count }))}>
          {t("pause.goOn")}
        </button>
        <button type="submit" class="button primary" disabled={busy.value || reason.value.trim() === ""}>
          {t("pause.do")}
        </button>
      </div>
    </form>
  );
}
