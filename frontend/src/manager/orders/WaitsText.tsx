import type { OrderView } from "../../api/types";
import { failureText } from "../../text/failure";
import { t } from "../../text/manager";

/** Why an order does not go on, in the strategist's words. */
export function WaitsText({ order }: { order: OrderView }) {
  const text = t("orders.waits", { reason: failureText(order.waits) });
  return (
    <span class="waits tone-warn" title={text}>
      {text}
    </span>
  );
}
