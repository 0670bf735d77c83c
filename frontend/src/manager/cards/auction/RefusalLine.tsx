import type { RefusalView } from "../../../api/types";
import { Link } from "../../../parts/Link";
import { failureText } from "../../../text/failure";
import { t, word } from "../../../text/manager";

/** Who did not bid, and why. */
export function RefusalLine({ refusal }: { refusal: RefusalView }) {
  return (
    <li class="bid bid-refused">
      <Link kind="atv" id={refusal.agent} />
      <span class="bid-note bid-reason">
        {t("auction.refused", { reason: word("reason", refusal.reason) })}
        {refusal.detail && <span class="faint"> · {failureText(refusal.detail)}</span>}
      </span>
    </li>
  );
}
