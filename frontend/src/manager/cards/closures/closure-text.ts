/** What a closure says of itself, and what a form asks for. */
import type { ClosureRequest, ClosureView, Outlook } from "../../../api/types";
import { laneOf, roadOf } from "../../../plant/surface/lanes";
import type { Corner } from "../../../selection/outline";
import { format, t } from "../../../text/manager";

export type Kind = ClosureView["kind"];

/** What stands for the shape that is drawn on the map, where something is to be chosen. */
export const DRAWN = "outline:drawn";

/** What is closed, in words: "c3 – m5-lane", also of a road of two lanes, "M5", the area's name. */
export function whereText(closure: Pick<ClosureView, "area" | "lane" | "outline" | "place">, areas: readonly { id: string; name: string }[]): string {
  const { area, lane, outline, place } = closure;
  if (lane) return t("closures.lane", roadOf(lane));
  if (outline.length > 0) return t("closures.drawnArea", { corners: outline.length });
  return place !== "" ? place : (areas.find(({ id }) => id === area)?.name ?? area);
}

/** How it is closed: "closed", "one-way", "0.5 m/s". */
export function howText({ kind, speed_mps: speedMps }: Pick<ClosureView, "kind" | "speed_mps">): string {
  return kind === "slow" ? t("closures.slowTo", { speed: format.number(speedMps ?? 0, 1) }) : t(`closures.is.${kind}`);
}

export interface Draft {
  /** `lane:START>END`, `place:ID`, `area:ID` or `DRAWN`. */
  readonly what: string;
  /** `one_way_back` is one-way from the lane's end to its start. */
  readonly kind: Kind | "one_way_back";
  readonly speed: string;
  /** As the field for a time gives it, local; empty for until it is opened. */
  readonly until: string;
  readonly reason: string;
}

/**
 * What is sent; null while something is missing.
 *
 * @param drawn the shape on the map, by its corners
 */
export function requestOf({ kind, reason, speed, until, what }: Draft, drawn: readonly Corner[]): ClosureRequest | null {
  const colon = what.indexOf(":");
  const name = what.slice(colon + 1);
  const lane = what.startsWith("lane:") ? laneOf(name) : null;
  const back = kind === "one_way_back";
  const speedMps = Number(speed);
  if (colon < 0 || name === "" || reason.trim() === "" || (kind === "slow" && !(speedMps >= 0.1))) return null;
  if (what === DRAWN && drawn.length < 3) return null;
  if (kind.startsWith("one_way") && !lane) return null;
  return {
    kind: back ? "one_way" : kind,
    ...(lane ? { lane: back ? { start: lane.end, end: lane.start } : lane } : what.startsWith("place:") ? { place: name } : {}),
    ...(what === DRAWN ? { outline: drawn.map(([x_m, y_m]) => ({ x_m, y_m })) } : what.startsWith("area:") ? { area: name } : {}),
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
