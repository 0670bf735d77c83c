import type { CauseView } from "../../api/types";
import { causeText, lacksText } from "../../text/failure";
import { t } from "../../text/manager";

/** Why an order does not go on: for want of material, or because nobody makes what is missing. */
export function WaitsText({ waits }: { waits: CauseView }) {
  const text =
    waits.lacks.length > 0
      ? t("orders.waitsFor", { materials: lacksText(waits.lacks) })
      : t("orders.waits", { reason: causeText(waits) });
  return (
    <span class="waits tone-warn" title={text}>
      {text}
    </span>
  );
}
