/** What stands below a Stop: the one thing about its vehicle that matters most to the hand above it. Pure. */
import type { AtvView } from "../../api/types";
import { type Moment, type Need, needOf } from "../cards/need";
import type { Command } from "../commands/life";

export type TileState =
  /** What has become of the Stop, as long as it is not confirmed. */
  | "sent"
  | "accepted"
  | "refused"
  | "not_confirmed"
  | "not_sent"
  /** It is not near any more. */
  | "away"
  | Need;

/** @param open the Stop of it that is not confirmed */
export function tileStateOf(atv: AtvView | undefined, open: Command | undefined, moment: Moment): TileState {
  if (open && open.stage !== "confirmed") return open.stage;
  return atv ? needOf(atv, moment) : "away";
}

export const TILE_TONES: Readonly<Record<TileState, "normal" | "warn" | "alarm">> = {
  sent: "warn", accepted: "warn", refused: "alarm", not_confirmed: "alarm", not_sent: "alarm",
  away: "normal", lost: "alarm", help: "warn", problem: "warn", coming: "normal", stopped: "normal",
  out: "normal", working: "normal", resting: "normal",
};
