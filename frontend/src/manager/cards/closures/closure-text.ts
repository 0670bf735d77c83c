/** What a closure says of itself, and what a form asks for. */
import type { ClosureRequest, ClosureView, Outlook } from "../../../api/types";
import { laneOf } from "../../../plant/surface/lanes";
import { t } from "../../../text/manager";

export type Kind = ClosureView["kind"];

/** What is closed, in words: "c3 – m5-lane", "M5", the area's name. */
export function whereText(closure: Pick<ClosureView, "area" | "lane" | "place">, areas: readonly { id: string; name: string }[]): string {
  const { area, lane, place } = closure;
  if (lane) return t("closures.lane", { start: lane.start, end: lane.end });
  return place !== "" ? place : (areas.find(({ id }) => id === area)?.name ?? area);
}

export interface Draft {
  /** `lane:START>END`, `place:ID` or `area:ID`. */
  readonly what: string;
  /** `one_way_back` is one-way from the lane's end to its start. */
  readonly kind: Kind | "one_way_back";
  readonly speed: string;
  /** As the field for a time gives it, local; empty for until it is opened. */
  readonly until: string;
  readonly reason: string;
}

/** What is sent; null while something is missing. */
export function requestOf({ kind, reason, speed, until, what }: Draft): ClosureRequest | null {
  const colon = what.indexOf(":");
  const name = what.slice(colon + 1);
  const lane = what.startsWith("lane:") ? laneOf(name) : null;
  const back = kind === "one_way_back";
  const speedMps = Number(speed);
  if (colon < 0 || name === "" || reason.trim() === "" || (kind === "slow" && !(speedMps >= 0.1))) return null;
  if (kind.startsWith("one_way") && !lane) return null;
  return {
    kind: back ? "one_way" : kind,
    ...(lane ? { lane: back ? { start: lane.end, end: lane.start } : lane } : what.startsWith("place:") ? { place: name } : { area: name }),
    ...(kind === "slow" ? { speed_mps: speedMps } : {}),
    ...(until === "" ? {} : { until: new Date(until).toISOString() }),
    reason: reason.trim(),
  };
}

/** What somebody should know before it is closed; empty when nothing is lost. */
export function warningsOf({ cut_off, shut_in }: Outlook): string[] {
  const warnings = [];
  if (cut_off.length > 0) warnings.push(t("closures.cutOff", { places: cut_off.join(", ") }));
  if (shut_in.length > 0) warnings.push(t("closures.shutIn", { vehicles: shut_in.join(", ") }));
  return warnings;
}
