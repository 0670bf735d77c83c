import type { OrderView } from "../../api/types";
import { failureText } from "../../text/failure";
import { t } from "../../text/manager";
import { shortageText } from "../../text/shortage";

/** Why an order does not go on: for want of material, or in the strategist's words. */
export function WaitsText({ order }: { order: OrderView }) {
  const materials = shortageText(order.waits);
  const text =
    materials === ""
      ? t("orders.waits", { reason: failureText(order.waits) })
      : t("orders.waitsFor", { materials });
  return (
    <span class="waits tone-warn" title={text}>
      {text}
    </span>
  );
}
