import type { RefusalView } from "../../../api/types";
import { Link } from "../../../parts/Link";
import { failureText } from "../../../text/failure";
import { t, word } from "../../../text/manager";

/** Who did not bid, and why. */
export function RefusalLine({ refusal }: { refusal: RefusalView }) {
  const { detail, reason } = refusal;
  // What keeps it from all work says more than that something does.
  const isDetail = reason === "not_fit" && detail !== "";
  return (
    <li class="bid bid-refused">
      <Link kind="atv" id={refusal.agent} />
      <span class="bid-note bid-reason">
        {t("auction.refused", { reason: isDetail ? failureText(detail) : word("reason", reason) })}
        {detail !== "" && !isDetail && <span class="faint"> · {failureText(detail)}</span>}
      </span>
    </li>
  );
}
