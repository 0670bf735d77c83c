import { useSignal } from "@preact/signals";
import type { OrderView } from "../../../api/types";
import { format, n, t } from "../../../text/views/order";
import { Sure } from "../../parts/Sure";
import { isClosed } from "../progress";
import { type Deed, doAll, isPossible, refused, running, ticked } from "./bulk";

const DEEDS = ["release", "revoke", "cancel"] as const;

/** What can be done to all orders whose box is ticked, and with which it did not work. Else it is not there. */
export function BulkBar({ orders, onDone }: { orders: readonly OrderView[]; onDone: () => void }) {
  const asking = useSignal<Deed | null>(null);
  const chosen = orders.filter((order) => ticked.value.has(order.id) && !isClosed(order));
  const failed = refused.value;
  if (chosen.length === 0 && failed.length === 0) return null;
  const able = (deed: Deed): OrderView[] => chosen.filter((order) => isPossible(deed, order));
  const run = async (deed: Deed): Promise<void> => {
    asking.value = null;
    await doAll(deed, able(deed));
    onDone();
  };
  const sure = chosen.length > 0 ? asking.value : null;
  const busy = running.value;
  return (
    <section class="bulk-bar card" aria-label={t("bulk.label")}>
      {chosen.length > 0 && <b>{n("bulk.chosen", chosen.length, format.count(chosen.length))}</b>}
      {busy && <span role="status">{t("bulk.running", { done: format.count(busy.done), of: format.count(busy.of) })}</span>}
      {!busy && sure === null && chosen.length > 0 && DEEDS.map((deed) => {
        const count = able(deed).length;
        return (
          <button key={deed} type="button" class="button small" disabled={count === 0} onClick={() => {
            if (deed === "release") void run(deed);
            else asking.value = deed;
          }}>
            {n(`bulk.${deed}`, count, format.count(count))}
          </button>
        );
      })}
      {!busy && sure !== null && (
        <Sure
          asked={n(`bulk.${sure === "cancel" ? "cancelSure" : "revokeSure"}`, able(sure).length, format.count(able(sure).length))}
          no={t(`bulk.${sure === "cancel" ? "cancelNot" : "revokeNot"}`)}
          yes={n(`bulk.${sure === "cancel" ? "cancelDo" : "revokeDo"}`, able(sure).length, format.count(able(sure).length))}
          busy={false}
          onNo={() => (asking.value = null)}
          onYes={() => void run(sure)}
        />
      )}
      {!busy && sure === null && (
        <button type="button" class="button small" onClick={() => {
          ticked.value = new Set();
          refused.value = [];
        }}>
          {t(chosen.length > 0 ? "bulk.none" : "bulk.dismiss")}
        </button>
      )}
      {failed.length > 0 && (
        <div role="alert">
          <ul class="complaint">
            {failed.map(({ order: { id, reference }, reason }) => (
              <li key={id}>{t("bulk.failed", { order: reference ?? id, reason })}</li>
            ))}
          </ul>
        </div>
      )}
    </section>
  );
}
