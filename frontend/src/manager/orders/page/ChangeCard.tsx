import { useSignal } from "@preact/signals";
import { useId } from "preact/hooks";
import { changeOrder, type OrderChange } from "../../../api/client";
import { Problem } from "../../../api/problem";
import type { OrderAnswer } from "../../../api/types";
import { Card } from "../../../parts/Card";
import { fieldsAfterSent } from "../../../parts/sent";
import { world } from "../../../stream/stream";
import { format, t } from "../../../text/views/order";
import { problemText } from "../../problem-text";
import { names } from "../../state";
import { PrioritySelect } from "../PrioritySelect";
import { Named } from "../Named";
import { isClosed } from "../progress";
import { changeOf, leastOf, type Written, writtenOf } from "./change";
import { passedBy } from "./change-costs";

/** What of an order may still be changed, with its limits, and what that costs others before it is saved. */
export function ChangeCard({ kept, onChanged }: { kept: OrderAnswer; onChanged: () => void }) {
  const read = useSignal(kept);
  const written = useSignal<Written>(writtenOf(kept));
  const busy = useSignal(false);
  const failed = useSignal("");
  const id = useId();
  const change = changeOf(read.value, written.value);
  if (change === null && read.value.etag !== kept.etag) {
    // Nothing is being written here: what others have changed is shown.
    read.value = kept;
    written.value = writtenOf(kept);
  }
  if (isClosed(kept)) return null;
  const edit = (more: Partial<Written>) => {
    written.value = { ...written.value, ...more };
    failed.value = "";
  };
  const undo = () => {
    read.value = kept;
    edit(writtenOf(kept));
  };
  const save = async (wanted: OrderChange) => {
    const sent = written.value;
    busy.value = true;
    try {
      const after = await changeOrder(kept.id, wanted, read.value.etag);
      read.value = after;
      written.value = fieldsAfterSent(sent, written.value, writtenOf(after));
      failed.value = "";
      onChanged();
    } catch (error) {
      const reasons = error instanceof Problem ? error.errors.map((each) => each.reason).join("; ") : "";
      failed.value = t("change.failed", { reason: reasons || problemText(error) });
    } finally {
      busy.value = false;
    }
  };
  const { due, priority, quantities, reference } = written.value;
  const wrong = change === "wrong";
  const costs = change === null || wrong ? null : passedBy(kept, change, world.value?.orders.values() ?? [], world.value?.factory.speed ?? 1);
  return (
    <Card title={t("change.title")} aside={<span class="muted">{t(kept.changing ? "change.underWay" : change === null ? "change.nothing" : "change.unsaved")}</span>} class="order-change">
      <form
        class="form"
        noValidate
        onSubmit={(event) => {
          event.preventDefault();
          if (change !== null && change !== "wrong") void save(change);
        }}
      >
        <div class="field order-change-wide">
          <label for={`${id}-due`}>{t("publish.due")}</label>
          <input id={`${id}-due`} type="datetime-local" value={due} onInput={(event) => { edit({ due: event.currentTarget.value }); }} />
        </div>
        <div class="field">
          <label for={`${id}-priority`}>{t("orders.priority")}</label>
          <PrioritySelect id={`${id}-priority`} value={priority} onChoose={(chosen) => { edit({ priority: chosen }); }} />
        </div>
        {kept.items.map((item, index) => (
          <div key={index} class="field">
            <label for={`${id}-${index}`}>{t("change.atLeast", { product: names.value(item.product), n: format.count(leastOf(item)) })}</label>
            <input
              id={`${id}-${index}`}
              inputMode="numeric"
              autoComplete="off"
              value={quantities[index] ?? ""}
              onInput={(event) => {
                const value = event.currentTarget.value;
                edit({ quantities: quantities.map((each, at) => (at === index ? value : each)) });
              }}
            />
          </div>
        ))}
        <div class="field order-change-wide">
          <label for={`${id}-reference`}>{t("publish.reference")}</label>
          <input id={`${id}-reference`} autoComplete="off" maxLength={80} value={reference} onInput={(event) => { edit({ reference: event.currentTarget.value }); }} />
        </div>
        <p class="muted" role="status">
          {wrong ? t("change.wrong") : costs === null ? t("change.hint") : costs.length === 0 ? t("change.passesNobody") : <Named text="change.passes" orders={costs} />}
        </p>
        <div class="form-actions">
          <button type="button" class="button" disabled={busy.value || change === null} onClick={undo}>
            {t("change.undo")}
          </button>
          <button type="submit" class="button primary" disabled={busy.value || change === null || wrong}>
            {t("change.save")}
          </button>
        </div>
      </form>
      {failed.value !== "" && (
        <p class="complaint" role="alert">
          {failed.value}
        </p>
      )}
    </Card>
  );
}
