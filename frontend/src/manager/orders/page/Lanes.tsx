import type { Signal } from "@preact/signals";
import { format, t } from "../../../text/views/order";
import { names } from "../../state";
import { type Bar, type Goal, type Group, percentOf, type Span, ticksOf, type Transport } from "./lanes";
import { loadOf, placeOf } from "./moments";

const TICKS = 7;

/** Behind a bar that ends further right, or before one that begins further left than its mirror image, a note has no room. */
const NOTE_FITS_PERCENT = 65;

interface Props {
  groups: readonly Group[];
  span: Span;
  nowS: number;
  dueS: number | null;
  /** The chosen transport's task; empty for none. */
  chosen: Signal<string>;
}

/** Goals, transports and hand-overs, on one axis of time. */
export function Lanes({ chosen, dueS, groups, nowS, span }: Props) {
  const left = (atS: number) => ({ left: `${percentOf(span, atS)}%` });
  const ticks = ticksOf(span, TICKS);
  const isFine = ticks.some((atS) => atS % 60 !== 0);
  return (
    <div class="lanes">
      <div class="lane lane-axis" aria-hidden="true">
        <span />
        <span class="lane-track">
          {ticks.map((atS) => (
            <i key={atS} class="lane-tick num" style={left(atS)}>
              {isFine ? format.clock(atS) : format.hour(atS)}
            </i>
          ))}
        </span>
      </div>
      {groups.map((group) => (
        <div key={group.goal.goal} role="group" aria-label={goalText(group.goal)}>
          <div class="lane lane-goal">
            <b>{goalText(group.goal)}</b>
            <Track bars={group.bars} span={span} note={madeText(group.goal)} ticks={ticks} marks={[nowS, dueS]} />
          </div>
          {group.transports.map(({ bars, transport }) => (
            <button
              key={transport.task}
              type="button"
              class="lane lane-transport"
              aria-pressed={chosen.value === transport.task}
              onClick={() => (chosen.value = chosen.value === transport.task ? "" : transport.task)}
            >
              <span>{titleOf(transport)}</span>
              <Track bars={bars} span={span} note={carriersOf(transport)} ticks={ticks} marks={[nowS, dueS]} />
            </button>
          ))}
        </div>
      ))}
    </div>
  );
}

interface TrackProps {
  bars: readonly Bar[];
  span: Span;
  note: string;
  ticks: readonly number[];
  /** Now, and when the order is due. */
  marks: readonly [number, number | null];
}

function Track({ bars, marks, note, span, ticks }: TrackProps) {
  const [nowS, dueS] = marks;
  const endPercent = bars.length > 0 ? Math.max(...bars.map((bar) => percentOf(span, bar.toS))) : percentOf(span, nowS);
  const startPercent = Math.min(...bars.map((bar) => percentOf(span, bar.fromS)), endPercent);
  // A note stands behind its bar, or before it where no room is left, and below it where there is none either.
  const isBelow = endPercent > NOTE_FITS_PERCENT && startPercent < 100 - NOTE_FITS_PERCENT;
  const noteAt = isBelow ? {} : endPercent > NOTE_FITS_PERCENT ? { right: `${100 - startPercent}%` } : { left: `${endPercent}%` };
  return (
    <span class={isBelow ? "lane-track lane-low" : "lane-track"}>
      {ticks.map((atS) => (
        <i key={atS} class="lane-grid" style={{ left: `${percentOf(span, atS)}%` }} />
      ))}
      {bars.map((bar, index) => (
        <i
          key={index}
          class={`lane-bar lane-${bar.kind}`}
          style={{ left: `${percentOf(span, bar.fromS)}%`, width: `${percentOf(span, bar.toS) - percentOf(span, bar.fromS)}%` }}
        />
      ))}
      {nowS < span.toS && <i class="lane-now" style={{ left: `${percentOf(span, nowS)}%` }} />}
      {dueS !== null && <i class="lane-due" style={{ left: `${percentOf(span, dueS)}%` }} />}
      <small class="lane-note" style={noteAt}>
        {note}
      </small>
    </span>
  );
}

function goalText(goal: Goal): string {
  const what = { load: loadOf(goal.product, goal.quantity), machine: goal.machine };
  return goal.ended === "" ? t("lanes.goal", what) : t(`lanes.${goal.ended}`, what);
}

function madeText(goal: Goal): string {
  const made = t("lanes.made", { made: format.count(goal.made), quantity: format.count(goal.quantity) });
  return goal.promised_at_s !== null && goal.made < goal.quantity && goal.ended === ""
    ? `${made} · ${t("lanes.promised", { at: format.hour(goal.promised_at_s) })}`
    : made;
}

function titleOf(transport: Transport): string {
  return t("lanes.transport", {
    load: `${format.count(transport.quantity)} ${names.value(transport.item)}`,
    from: placeOf(transport.source),
    to: placeOf(transport.destination),
  });
}

function carriersOf(transport: Transport): string {
  if (transport.legs.length === 0) return t("lanes.nobody");
  return transport.legs.map((leg) => (leg.replaced === "" ? leg.carrier : `${leg.carrier} ✕`)).join(" → ");
}
