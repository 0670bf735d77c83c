import { useSignal } from "@preact/signals";
import { useEffect, useMemo } from "preact/hooks";
import { layers } from "../../../plant/controls/layers";
import { wholeOf } from "../../../plant/surface/geometry";
import { PlantSurface } from "../../../plant/surface/PlantSurface";
import { nowS } from "../../../stream/stream";
import { speakAlso } from "../../../text/speech";
import { format, t, tables } from "../../../text/views/replay";
import { KeptNote } from "../../parts/kept/KeptNote";
import { plant } from "../../state";
import { addressOfMoment, momentFrom } from "../../views";
import { Band } from "./Band";
import { MomentCard } from "./MomentCard";
import "./replay.css";
import { Scrubber } from "./Scrubber";
import { atS, edgeS, failed, notKept, past, playing, run, seek, SOURCE } from "./state";
import { Strips } from "./Strips";

/** Without a moment in the address: what was a little while ago. */
const AGO_S = 60;
/** What is shown may be so much older than the moment before it is said. */
const OLDER_S = 5;

/** The page, once it has its words. */
export async function load(): Promise<typeof Replay> {
  await speakAlso(tables);
  return Replay;
}

/** The plant as it was: the moment is in the address, and everything here shows that one. */
export function Replay() {
  const floor = plant.value;
  const home = useMemo(() => (floor ? wholeOf(floor) : null), [floor]);
  const begun = useSignal(false);
  useEffect(() => {
    // What this page has read or written there last: another one is somebody's, and one is told of it a little later.
    let known = location.hash;
    const follow = (): void => {
      if (!location.hash.startsWith("#replay")) return;
      known = location.hash;
      const wanted = momentFrom(location.hash);
      // What this page has written into the address itself is shown already.
      if (!begun.value || (wanted !== null && addressOfMoment(wanted) !== addressOfMoment(atS.value))) seek(wanted ?? edgeS() - AGO_S);
      begun.value = true;
    };
    follow();
    addEventListener("hashchange", follow);
    const stop = run();
    const keep = setInterval(() => {
      if (playing.value || location.hash !== known) return;
      known = addressOfMoment(atS.value);
      history.replaceState(null, "", known);
    }, 500);
    return () => {
      removeEventListener("hashchange", follow);
      clearInterval(keep);
      stop();
    };
  }, [begun]);
  const shown = past.value;
  const isOlder = shown !== null && atS.value - shown.atS > OLDER_S;
  return (
    <main class="replay" id="content" tabIndex={-1}>
      <Band />
      {failed.value !== null && (
        <p class="replay-note tone-alarm" role="alert">
          {t("replay.failed", { reason: failed.value })}
        </p>
      )}
      {notKept.value && (
        <div class="replay-note tone-warn">
          {t("replay.notKept", { at: format.when(atS.value, nowS.value) })}
          <KeptNote kind="replay" fromS={atS.value} />
        </div>
      )}
      {isOlder && (
        <p class="replay-note tone-warn" role="status">
          {t("replay.older", { at: format.when(shown.atS, nowS.value) })}
        </p>
      )}
      <div class="replay-top">
        <section class="card map replay-map" aria-label={t("replay.map")} aria-busy={shown === null && !notKept.value && failed.value === null}>
          {plant.value && home && <PlantSurface plant={plant.value} home={home} layers={layers} label={t("replay.map")} source={SOURCE} />}
        </section>
        <MomentCard />
      </div>
      <section class="card replay-time" aria-label={t("scrub.title")}>
        <Scrubber />
        <Strips />
      </section>
    </main>
  );
}
