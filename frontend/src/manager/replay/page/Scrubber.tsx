import { useSignal, useSignalEffect } from "@preact/signals";
import { askAgain } from "../../../api/ask-again";
import { nowS } from "../../../stream/stream";
import { format, t } from "../../../text/views/replay";
import { ticksOf } from "../../orders/page/lanes";
import { fetchOverview } from "./api";
import { type Mark, type Range, rangeAround } from "./film";
import { markText } from "./marks";
import { atS, edgeS, overview, seek } from "./state";

const LENGTHS_S = { fortnight: 14 * 86_400, day: 86_400, shift: 8 * 3600, hour: 3600 } as const;
type Length = keyof typeof LENGTHS_S;

/** New pieces are kept every half minute. */
const AGAIN_MS = 20_000;
const GLYPHS: Record<string, string> = { takeover: "M0-5L5 0 0 5-5 0z", failure: "M-4-4L4 4M4-4L-4 4", alert: "M0-5L5 4H-5z", late: "M0-5A5 5 0 1 1 0 5 5 5 0 1 1 0-5M0-3V0H3" };

/** One time with how much happened in it and what people look for, and the moment in it. */
export function Scrubber() {
  const length = useSignal<Length>("shift");
  const range = useSignal<Range>({ fromS: 0, toS: 0 });
  useSignalEffect(() => {
    const lengthS = LENGTHS_S[length.value];
    const { fromS, toS } = range.peek();
    const at = atS.value;
    if (toS - fromS !== lengthS || at < fromS || at > toS) range.value = rangeAround(at, lengthS, edgeS());
  });
  useSignalEffect(() => {
    const asked = range.value;
    if (asked.toS <= 0) return undefined;
    return askAgain(() => fetchOverview(asked), (found) => { overview.value = found; }, AGAIN_MS);
  });
  const { fromS, toS } = range.value;
  const found = overview.value;
  const percent = (at: number): number => Math.min(100, Math.max(0, ((at - fromS) / Math.max(1, toS - fromS)) * 100));
  return (
    <div class="scrubber">
      <header class="card-head">
        <h2>{t("scrub.title")}</h2>
        <span class="count">{found?.kept_from_at_s == null ? t("scrub.none") : t("scrub.kept", { from: format.when(found.kept_from_at_s, nowS.value) })}</span>
        <span class="muted scrub-hint">{t("scrub.hint")}</span>
        <div class="card-aside">
          <span class="segments" role="group" aria-label={t("scrub.range")}>
            {(Object.keys(LENGTHS_S) as Length[]).map((each) => (
              <button key={each} type="button" aria-pressed={length.value === each} onClick={() => (length.value = each)}>
                {t(`scrub.range.${each}`)}
              </button>
            ))}
          </span>
        </div>
      </header>
      <div class="scrub-body">
        <Marks marks={found?.marks ?? []} percent={percent} />
        <Density parts={found?.density ?? []} />
        <input
          type="range"
          aria-label={t("scrub.moment")}
          aria-valuetext={`${format.day(atS.value)} ${format.clock(atS.value)}`}
          min={fromS}
          max={toS}
          step={1}
          value={atS.value}
          onInput={(event) => { seek(Number(event.currentTarget.value)); }}
        />
        <span class="scrub-ticks" aria-hidden="true">
          {toS > fromS && ticksOf({ fromS, toS }, 9).map((at) => (
            <i key={at} class="num" style={{ left: `${percent(at)}%` }}>
              {length.value === "fortnight" ? format.day(at) : format.hour(at)}
            </i>
          ))}
        </span>
      </div>
      {found !== null && found.marks_left_out > 0 && <small class="muted">{t("scrub.leftOut", { n: format.count(found.marks_left_out) })}</small>}
    </div>
  );
}

/** For the pointer; by keyboard there are the buttons of the band. */
function Marks({ marks, percent }: { marks: readonly Mark[]; percent: (atS: number) => number }) {
  return (
    <div class="scrub-marks" aria-hidden="true">
      {marks.map((mark, index) => (
        <svg
          key={`${mark.at_s}-${index}`}
          class={`mark mark-${mark.kind}`}
          viewBox="-7 -7 14 14"
          style={{ left: `${percent(mark.at_s)}%` }}
          onClick={() => { seek(mark.at_s); }}
        >
          <title>{markText(mark)}</title>
          <path d={GLYPHS[mark.kind] ?? ""} />
        </svg>
      ))}
    </div>
  );
}

function Density({ parts }: { parts: readonly number[] }) {
  const most = Math.max(1, ...parts);
  return (
    <svg class="scrub-density" viewBox={`0 0 ${Math.max(1, parts.length)} 1`} preserveAspectRatio="none" aria-hidden="true">
      {parts.map((count, index) => (
        <rect key={index} x={index + 0.1} width={0.8} y={1 - count / most} height={count / most} />
      ))}
    </svg>
  );
}
