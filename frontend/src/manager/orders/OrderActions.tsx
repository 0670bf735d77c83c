import { useSignal } from "@preact/signals";
import { cancelOrder, releaseOrder, revokeOrder } from "../../api/client";
import type { OrderView } from "../../api/types";
import { t } from "../../text/manager";
import { problemText } from "../problem-text";
import { Sure } from "../parts/Sure";
import { canBeTakenBack, isClosed } from "./progress";

/** What can be done about an order. */
const DEEDS = {
  release: { run: releaseOrder, failed: "orders.releaseFailed" },
  revoke: { run: revokeOrder, failed: "orders.revokeFailed" },
  cancel: { run: cancelOrder, failed: "orders.cancelFailed" },
} as const;
type Deed = keyof typeof DEEDS;

/** Publish what was only defined; take back what is in work, or cancel it, after a second thought. */
export function OrderActions({ order, all = false }: { order: OrderView; all?: boolean }) {
  const busy = useSignal(false);
  const asking = useSignal<"revoke" | "cancel" | null>(null);
  const failed = useSignal("");
  if (isClosed(order)) return null;
  const run = async (deed: Deed) => {
    busy.value = true;
    failed.value = "";
    try {
      await DEEDS[deed].run(order.id);
      asking.value = null;
    } catch (error) {
      failed.value = t(DEEDS[deed].failed, { reason: problemText(error) });
    } finally {
      busy.value = false;
    }
  };
  const button = (label: "orders.release" | "orders.revoke" | "orders.cancel", onClick: () => void) => (
    <button type="button" class="button small" disabled={busy.value} onClick={onClick}>
      {t(label)}
    </button>
  );
  const sure = asking.value;
  return (
    <span class="order-actions">
      {sure === null ? (
        <>
          {order.status === "stored" && button("orders.release", () => void run("release"))}
          {all && canBeTakenBack(order) && button("orders.revoke", () => (asking.value = "revoke"))}
          {all && button("orders.cancel", () => (asking.value = "cancel"))}
        </>
      ) : (
        <Sure
          asked={t(`orders.${sure}Sure`)}
          no={t(`orders.${sure}Not`)}
          yes={t(`orders.${sure}Do`)}
          busy={busy.value}
          onNo={() => (asking.value = null)}
          onYes={() => void run(sure)}
        />
      )}
      {failed.value !== "" && (
        <span class="complaint" role="alert">
          {failed.value}
        </span>
      )}
    </span>
  );
}
