import { useSignal } from "@preact/signals";
import { endClosure } from "../../../api/client";
import type { ClosureView } from "../../../api/types";
import { nowS, world } from "../../../stream/stream";
import { format, t } from "../../../text/manager";
import { problemText } from "../../problem-text";
import { plant } from "../../state";
import { howText, whereText } from "./closure-text";

/** What people have closed to vehicles: by whom, why, until when, and the way back. Nothing while all is open. */
export function ClosuresCard() {
  const closures = [...(world.value?.closures.values() ?? [])];
  if (closures.length === 0) return null;
  return (
    <section class="card closures" aria-labelledby="closures">
      <header class="card-head">
        <h2 id="closures">{t("closures.title")}</h2>
      </header>
      <ul class="closure-list">
        {closures.map((closure) => (
          <Line key={closure.id} closure={closure} />
        ))}
      </ul>
    </section>
  );
}

function Line({ closure }: { closure: ClosureView }) {
  const busy = useSignal(false);
  const failed = useSignal("");
  const end = async () => {
    busy.value = true;
    failed.value = "";
    try {
      await endClosure(closure.id);
    } catch (error) {
      failed.value = t("closures.failed", { reason: problemText(error) });
    } finally {
      busy.value = false;
    }
  };
  const { at_s: atS, by, cut_off: cutOff, not_known_by: unaware, reason, until_at_s: untilS } = closure;
  const where = whereText(closure, plant.value?.areas ?? []);
  const at = format.due(atS, nowS.value);
  return (
    <li>
      <p>
        <strong>{where}</strong> · {howText(closure)}
        <span class="line">{reason}</span>
        <small class="line muted">
          {untilS === null ? t("closures.since", { at, by }) : t("closures.sinceUntil", { at, by, until: format.due(untilS, nowS.value) })}
        </small>
        {cutOff.length > 0 && <small class="line tone-warn">{t("closures.cutOff", { places: cutOff.join(", ") })}</small>}
        {unaware.length > 0 && <small class="line tone-warn">{t("closures.unaware", { vehicles: unaware.join(", ") })}</small>}
        {failed.value !== "" && (
          <small class="line" role="alert">
            {failed.value}
          </small>
        )}
      </p>
      <button type="button" class="button small" disabled={busy.value} aria-label={t("closures.endOf", { where })} onClick={() => void end()}>
        {t("closures.end")}
      </button>
    </li>
  );
}
