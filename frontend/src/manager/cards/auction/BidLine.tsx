import { Link } from "../../../parts/Link";
import { format, t, word } from "../../../text/manager";
import { factoryTime } from "../../../text/plant-time";
import type { BidView } from "../../../api/types";
import { barOf, type BidRow } from "./auction";

interface Props {
  row: BidRow;
  parts: readonly string[];
  mostS: number;
  /** Whether the carrier is the one that the auction ended with. */
  won: boolean;
}

/** One bid: its parts to the scale of the dearest one, its total, what came of it. */
export function BidLine({ row, parts, mostS, won }: Props) {
  const { bid, standing } = row;
  const spoken = parts.map((part) => `${word("part", part)} ${format.duration(bid.parts_s[part] ?? 0)}`);
  const label = t("auction.bidLabel", {
    bidder: bid.bidder,
    total: factoryTime(bid.total_s),
    parts: format.list(spoken),
  });
  const note = noteOf(row, won);
  return (
    <li class={`bid ${won && standing === "primary" ? "bid-won" : ""}`}>
      <span class="bid-who">
        <Link kind="atv" id={bid.bidder} />
        {bid.battery_reckoned && <small class="muted" title={t("auction.reckonedWhy")}>{t("auction.reckoned")}</small>}
      </span>
      <span class="bid-bar" role="img" aria-label={label} title={label}>
        {barOf(bid, parts, mostS).map(({ frac, part }) => (
          <i key={part} class={`part-${part}`} style={{ width: `${frac * 100}%` }} />
        ))}
      </span>
      <span class="num">{format.duration(bid.total_s)}</span>
      <span class="bid-note" title={note}>
        {note}
      </span>
    </li>
  );
}

function noteOf({ bid, standing }: BidRow, won: boolean): string {
  if (standing === "primary" && !won) return t("auction.role.tookOver");
  return standing ? t(`auction.role.${standing}`) : answerText(bid);
}

/** What the bidder said when it was asked; empty where it was not. */
export function answerText({ answer }: BidView): string {
  if (answer === "" || answer === "accepted") return "";
  if (answer === "asked" || answer === "silent") return t(`auction.answer.${answer}`);
  return t("auction.answer.declined", { reason: word("reason", answer) });
}
