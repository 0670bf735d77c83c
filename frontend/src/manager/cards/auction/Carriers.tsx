import type { CarrierView } from "../../../api/types";
import { Link } from "../../../parts/Link";
import { format, t } from "../../../text/manager";

/** The newest: more would not fit into one line. */
const MOST = 4;

/** Who carried the task from when on, one step per epoch. */
export function Carriers({ carriers }: { carriers: readonly CarrierView[] }) {
  return (
    <ol class="carriers" aria-label={t("auction.carriers")}>
      {carriers.slice(-MOST).map((each) => (
        <li key={each.epoch} title={each.confirmed ? labelOf(each) : t("auction.unconfirmed")}>
          <span class="epoch">{each.epoch}</span>
          {each.carrier === "" ? t("auction.anew") : <Link kind="atv" id={each.carrier} />}
          <span class="faint">{format.clock(each.since_at_s)}</span>
        </li>
      ))}
    </ol>
  );
}

function labelOf({ carrier, epoch, since_at_s: sinceAtS }: CarrierView): string {
  return t("auction.carrierLabel", { epoch, carrier: carrier || t("auction.anew"), at: format.clock(sinceAtS) });
}
