import { useSignal } from "@preact/signals";
import { cancelOrder, releaseOrder } from "../../api/client";
import type { OrderView } from "../../api/types";
import { t } from "../../text/manager";
import { problemText } from "../problem-text";
import { isClosed } from "./progress";

/** Publish what was only defined; cancel what is no longer wanted, after a second thought. */
export function OrderActions({ order, canCancel = false }: { order: OrderView; canCancel?: boolean }) {
  const busy = useSignal(false);
  const asking = useSignal(false);
  const failed = useSignal("");
  const run = async (what: (id: string) => Promise<void>, message: (reason: string) => string) => {
    busy.value = true;
    failed.value = "";
    try {
      await what(order.id);
      asking.value = false;
    } catch (error) {
      failed.value = message(problemText(error));
    } finally {
      busy.value = false;
    }
  };
  const act = (label: "orders.release" | "orders.cancel" | "orders.keep", onClick: () => void) => (
    <button type="button" class="button small" disabled={busy.value} onClick={onClick}>
      {t(label)}
    </button>
  );
  if (isClosed(order)) return null;
  return (
    <span class="order-actions">
      {order.status === "stored" &&
        act("orders.release", () => void run(releaseOrder, (reason) => t("orders.releaseFailed", { reason })))}
      {canCancel && !asking.value && act("orders.cancel", () => (asking.value = true))}
      {asking.value && (
        <>
          <span>{t("orders.cancelSure")}</span>
          {act("orders.cancel", () => void run(cancelOrder, (reason) => t("orders.cancelFailed", { reason })))}
          {act("orders.keep", () => (asking.value = false))}
        </>
      )}
      {failed.value !== "" && (
        <span class="complaint" role="alert">
          {failed.value}
        </span>
      )}
    </span>
  );
}
