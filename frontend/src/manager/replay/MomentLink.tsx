import { Icon } from "../../parts/Icon";
import { t } from "../../text/manager";
import { addressOfMoment } from "../views";

/** Leads to the plant as it was at a moment. */
export function MomentLink({ about, atS }: { atS: number; about: string }) {
  const label = t("replay.showMoment", { about });
  return (
    <a class="moment-link" href={addressOfMoment(atS)} aria-label={label} title={t("replay.show")}>
      <Icon name="past" />
    </a>
  );
}
