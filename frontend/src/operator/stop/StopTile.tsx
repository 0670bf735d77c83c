import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import type { AtvView } from "../../api/types";
import { selection } from "../../selection/selection";
import { world } from "../../stream/stream";
import { format, t, word } from "../../text/operator";
import { distanceM } from "../area/region";
import { give } from "../commands/given";
import { moment, station } from "../state";
import { openStops } from "./open";
import type { Place } from "./places";
import { isSettling } from "./seats";
import { TILE_TONES, type TileState, tileStateOf } from "./tile";

/** Long enough to read that a touch did not count. */
const TOLD_MS = 2000;

/**
 * Stops a vehicle with one touch. It is never disabled and never hidden behind anything, and a touch on it never
 * scrolls. Only for the moment after another vehicle had this place it does not count: it says so then.
 */
export function StopTile({ place }: { place: Place }) {
  const atv = world.value?.atvs.get(place.atv);
  const state = tileStateOf(atv, openStops.value.get(place.atv), moment.value);
  const settling = isSettling(place);
  const tooSoon = useSignal(false);
  /** When the finger came down counts: whoever pressed before it was settled has meant something else. */
  const pressedTooSoon = useRef(false);
  useEffect(() => {
    if (!tooSoon.value) return undefined;
    const timer = setTimeout(() => (tooSoon.value = false), TOLD_MS);
    return () => {
      clearTimeout(timer);
    };
  });
  const touched = (): void => {
    tooSoon.value = pressedTooSoon.current || isSettling(place);
    pressedTooSoon.current = false;
    if (!tooSoon.value) void give(place.atv, { kind: "stop" });
  };
  const looks = [
    "stop", `stop-${TILE_TONES[state]}`, settling || tooSoon.value ? "settling" : "", atv ? "" : "away",
    selection.value.atv === place.atv ? "chosen" : "",
  ];
  return (
    <button
      type="button"
      id={`stop-${place.atv}`}
      class={looks.filter(Boolean).join(" ")}
      aria-describedby="stop-not"
      onPointerDown={() => {
        pressedTooSoon.current = isSettling(place);
      }}
      onClick={touched}
    >
      <span class="stop-name">
        <small>{t("command.stop")}</small> <b>{place.atv}</b>
      </span>{" "}
      <span class="stop-state">
        <span>{tooSoon.value ? t("stop.tooSoon") : lineText(state, atv)}</span>
      </span>
    </button>
  );
}

function lineText(state: TileState, atv: AtvView | undefined): string {
  switch (state) {
    case "sent":
    case "accepted":
    case "refused":
    case "not_confirmed":
    case "not_sent":
      return t(`stage.${state}`);
    case "away":
      return t("stop.away");
    case "lost":
      return t("stop.silent", { age: format.age(moment.value.nowS - (atv?.seen_at_s ?? 0)) });
    case "working":
    case "resting":
      return whereText(atv);
    default:
      return t(`need.${state}`);
  }
}

/** How far it is from where this person works, else what it does. */
function whereText(atv: AtvView | undefined): string {
  if (!atv) return "";
  const from = station.value;
  return from ? t("card.away", { metres: format.count(distanceM(from, atv)) }) : word("atv", atv.status);
}
