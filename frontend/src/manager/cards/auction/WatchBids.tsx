import { Link } from "../../../parts/Link";
import { format, t } from "../../../text/manager";
import { Term } from "../../story/Term";
import type { BidRow } from "./auction";
import { answerText } from "./BidLine";

/**
 * The auction for the watch, in one line. Its prices are for standing by, and stand nowhere beside those for the
 * contract: they would look like cheaper bids for that.
 */
export function WatchBids({ rows }: { rows: readonly BidRow[] }) {
  return (
    <p class="watch-bids">
      <Term name="watch">{t("auction.watchBids")}</Term>
      {rows.map(({ bid, standing }) => {
        const answer = standing === "secondary" ? t("auction.watches") : bid.answer === "accepted" ? t("auction.watched") : answerText(bid);
        return (
          <span key={bid.bidder} title={answer}>
            <Link kind="atv" id={bid.bidder} /> <span class="num">{format.duration(bid.total_s)}</span>
            {answer !== "" && <span class="muted"> {answer}</span>}
          </span>
        );
      })}
    </p>
  );
}
