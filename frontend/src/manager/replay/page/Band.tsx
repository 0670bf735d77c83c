import { Icon } from "../../../parts/Icon";
import { nowS } from "../../../stream/stream";
import { format, t } from "../../../text/views/replay";
import { orderName } from "../../state";
import { addressOf } from "../../views";
import { markBeside } from "./film";
import { leadText } from "./marks";
import { atS, overview, playing, rate, RATES, seekMark, setPlaying, setRate } from "./state";

const NEAR_S = 1;

/** Says at once that this is the past, and lets it go on. */
export function Band() {
  const marks = overview.value?.marks ?? [];
  const at = atS.value;
  const before = markBeside(marks, at, -1);
  const next = markBeside(marks, at, 1);
  const here = marks.filter((mark) => Math.abs(mark.at_s - at) <= NEAR_S);
  const ageS = nowS.value - at;
  return (
    <header class="replay-band">
      <div class="replay-when">
        <h1 class="num">
          {format.day(at)} {format.clock(at)}
        </h1>
        <p>{ageS < 5 ? t("replay.now") : t("replay.ago", { age: format.duration(ageS) })}</p>
        <p role="status" class="replay-mark">
          {here.map((mark, index) => (
            <span key={`${mark.kind} ${String(index)}`}>
              {index > 0 && " · "}
              {leadText(mark)}
              {mark.order !== "" && <a class="link" href={addressOf(mark.order)}>{orderName(mark.order)}</a>}
            </span>
          ))}
        </p>
      </div>
      <div class="replay-buttons">
        <button type="button" class="button" disabled={before === null} onClick={() => { seekMark(before); }}>
          <Icon name="before" /> {t("replay.before")}
        </button>
        <button type="button" class="button" onClick={() => { setPlaying(!playing.value); }}>
          <Icon name={playing.value ? "pause" : "play"} /> {t(playing.value ? "replay.pause" : "replay.play")}
        </button>
        <button type="button" class="button" disabled={next === null} onClick={() => { seekMark(next); }}>
          <Icon name="after" /> {t("replay.next")}
        </button>
        <span class="segments" role="group" aria-label={t("replay.rate")}>
          {RATES.map((each) => (
            <button key={each} type="button" aria-pressed={rate.value === each} onClick={() => { setRate(each); }}>
              {t("replay.times", { n: each === 0.25 ? "¼" : format.count(each) })}
            </button>
          ))}
        </span>
        <a class="button primary" href="#plant">
          {t("replay.live")}
        </a>
      </div>
    </header>
  );
}
