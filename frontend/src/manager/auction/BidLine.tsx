import { Link } from "../../parts/Link";
import { format, t, word } from "../../text/manager";
import type { BidRow } from "./auction";

interface Props {
  row: BidRow;
  parts: readonly string[];
  mostS: number;
}

/** One bid: its parts to the scale of the dearest one, its total, what came of it. */
export function BidLine({ row, parts, mostS }: Props) {
  const { bid, standing } = row;
  const spoken = parts.map((part) => `${word("part", part)} ${format.duration(bid.parts_s[part] ?? 0)}`);
  const label = t("auction.bidLabel", {
    bidder: bid.bidder,
    total: format.duration(bid.total_s),
    parts: format.list(spoken),
  });
  const note = noteOf(row);
  return (
    <li class={`bid ${standing === "primary" ? "bid-won" : ""}`}>
      <Link kind="atv" id={bid.bidder} />
      <span class="bid-bar" role="img" aria-label={label} title={label}>
        {parts.map((part) => (
          <i key={part} class={`part-${part}`} style={{ width: `${((bid.parts_s[part] ?? 0) / mostS) * 100}%` }} />
        ))}
      </span>
      <span class="num">{format.duration(bid.total_s)}</span>
      <span class="bid-note" title={note}>
        {note}
      </span>
    </li>
  );
}

function noteOf({ bid, standing }: BidRow): string {
  if (standing) return t(`auction.role.${standing}`);
  const forWatch = bid.role === "secondary";
  if (bid.answer === "" || bid.answer === "accepted") return forWatch ? t("auction.forWatch") : "";
  if (bid.answer === "asked") return t("auction.answer.asked");
  if (bid.answer === "silent") return t("auction.answer.silent");
  return t(forWatch ? "auction.answer.noWatch" : "auction.answer.declined", { reason: word("reason", bid.answer) });
}
