import { format, n, t } from "../../../text/views/order";
import { placesOf } from "../../state";
import { chooseTransport, chosenTransport } from "./address";
import { type Bar, barsOfExpected, type Goal, type Group, percentOf, type Sign, signsOf, type Span, type Story, ticksOf, type Transport } from "./lanes";
import { loadOf, placeOf } from "./moments";

const TICKS = 7;

/** Behind a bar that ends further right, or before one that begins further left than its mirror image, a note has no room. */
const NOTE_FITS_PERCENT = 65;

/** A longer note, in characters, has no room beside a bar. */
const NOTE_BESIDE_MOST = 40;

interface Props {
  groups: readonly Group[];
  span: Span;
  nowS: number;
  dueS: number | null;
  /** When all of it may be delivered; null where nobody can tell, and once it is. */
  expected: Story["expected"];
}

/** Goals, transports and hand-overs, on one axis of time. */
export function Lanes({ dueS, expected, groups, nowS, span }: Props) {
  const shared = sharedOf(span, nowS, dueS);
  return (
    <div class="lanes">
      <Axis {...shared} nowS={nowS} />
      {groups.map((group) => (
        <div key={group.goal.goal} role="group" aria-label={goalText(group.goal)}>
          <div class="lane lane-goal">
            <b>{goalText(group.goal)}</b>
            <Track {...shared} bars={group.bars} note={goalNote(group.goal, nowS)} />
          </div>
          {group.transports.map((each) => (
            <TransportLane key={each.transport.task} {...shared} {...each} />
          ))}
        </div>
      ))}
      {expected !== null && (
        <div class="lane lane-goal">
          <b>{t("orderPage.delivered")}</b>
          <Track {...shared} bars={barsOfExpected(expected, nowS)} note={expectedText(expected, nowS)} />
        </div>
      )}
    </div>
  );
}

interface TransportProps extends Omit<Props, "groups"> {
  attempts: Group["transports"];
}

/** How a plain transport was given out and carried, on the same axis. */
export function TransportLanes({ attempts, dueS, expected, nowS, span }: TransportProps) {
  const shared = sharedOf(span, nowS, dueS);
  return (
    <div class="lanes">
      <Axis {...shared} nowS={nowS} />
      {attempts.map((each) => (
        <TransportLane key={each.transport.task} {...shared} {...each} />
      ))}
      {expected !== null && (
        <div class="lane lane-goal">
          <b>{t("orderPage.delivered")}</b>
          <Track {...shared} bars={barsOfExpected(expected, nowS)} note={t("lanes.expectedAt", { at: format.due(expected.to_at_s, nowS) })} />
        </div>
      )}
    </div>
  );
}

type Shared = Pick<TrackProps, "signs" | "span" | "ticks">;

function sharedOf(span: Span, nowS: number, dueS: number | null): Shared {
  return { signs: signsOf(span, nowS, dueS), span, ticks: ticksOf(span, TICKS) };
}

function Axis({ nowS, signs, span, ticks }: Shared & { nowS: number }) {
  const isFine = ticks.some((atS) => atS % 60 !== 0);
  return (
    <>
      <div class="lane lane-axis">
        <span />
        <span class="lane-track" aria-hidden="true">
          {ticks.map((atS) => (
            <i key={atS} class="lane-tick num" style={{ left: `${percentOf(span, atS)}%` }}>
              {isFine ? format.clock(atS) : format.hour(atS)}
            </i>
          ))}
        </span>
      </div>
      {signs.length > 0 && <Signs signs={signs} span={span} nowS={nowS} />}
    </>
  );
}

function TransportLane({ bars, transport, ...shared }: Shared & Group["transports"][number]) {
  const isChosen = chosenTransport.value === transport.task;
  return (
    <button type="button" class="lane lane-transport" aria-pressed={isChosen} onClick={() => { chooseTransport(isChosen ? "" : transport.task); }}>
      <span>{titleOf(transport)}</span>
      <Track {...shared} bars={bars} note={carriersOf(transport)} />
    </button>
  );
}

interface SignsProps {
  signs: readonly Sign[];
  span: Span;
  nowS: number;
}

/** Their lines go on through all lanes. */
function Signs({ nowS, signs, span }: SignsProps) {
  return (
    <div class="lane lane-signs">
      <span />
      <span class={signs.some(({ row }) => row > 0) ? "lane-track lane-two-rows" : "lane-track"}>
        <SignLines signs={signs} span={span} />
        {signs.map(({ atS, kind, row }) => (
          <span
            key={kind}
            class={`lane-sign lane-sign-${kind} lane-row-${String(row)} num`}
            // As far to the left of its line as the line is along the axis: so it never leaves the axis.
            style={{ left: `${percentOf(span, atS)}%`, transform: `translateX(-${percentOf(span, atS)}%)` }}
          >
            {t(`lanes.${kind}`, { at: kind === "due" ? format.due(atS, Number.isFinite(nowS) ? nowS : atS) : format.hour(atS) })}
          </span>
        ))}
      </span>
    </div>
  );
}

function SignLines({ signs, span }: { signs: readonly Sign[]; span: Span }) {
  return (
    <>
      {signs.map(({ atS, kind }) => (
        <i key={kind} class={`lane-${kind}`} style={{ left: `${percentOf(span, atS)}%` }} />
      ))}
    </>
  );
}

interface TrackProps {
  bars: readonly Bar[];
  span: Span;
  note: string;
  ticks: readonly number[];
  signs: readonly Sign[];
}

function Track({ bars, note, signs, span, ticks }: TrackProps) {
  const nowS = signs.find(({ kind }) => kind === "now")?.atS ?? span.toS;
  const endPercent = bars.length > 0 ? Math.max(...bars.map((bar) => percentOf(span, bar.toS))) : percentOf(span, nowS);
  const startPercent = Math.min(...bars.map((bar) => percentOf(span, bar.fromS)), endPercent);
  // A note stands behind its bar, or before it where no room is left, and below it where there is none either.
  const isBelow = note.length > NOTE_BESIDE_MOST || (endPercent > NOTE_FITS_PERCENT && startPercent < 100 - NOTE_FITS_PERCENT);
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
      <SignLines signs={signs} span={span} />
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

/** How far it is, why its machine does not work at it, and what was promised of it. */
export function goalNote(goal: Goal, nowS: number): string {
  const made = t("lanes.made", { made: format.count(goal.made), quantity: format.count(goal.quantity) });
  if (goal.made >= goal.quantity || goal.ended !== "") return made;
  return [made, waitNote(goal), promiseNote(goal, nowS)].filter((part) => part !== "").join(" · ");
}

/** When it is promised, and when it was first promised if that was moved, and why. Of an order that has ended nothing is overdue any more. */
function promiseNote({ came_before: came, first_promised_at_s: firstS, promised_at_s: promisedS }: Goal, nowS: number): string {
  if (promisedS === null || !Number.isFinite(nowS)) return "";
  const promised = t(promisedS < nowS ? "lanes.overdue" : "lanes.promised", { at: format.hour(promisedS) });
  if (firstS === null) return promised;
  const moved = `${promised}, ${t("lanes.moved", { first: format.hour(firstS) })}`;
  // Other goals that have left explain an earlier time; what came before it does not.
  return came > 0 && promisedS > firstS ? `${moved}: ${n("lanes.came", came, format.count(came))}` : moved;
}

function waitNote({ behind, doing }: Goal): string {
  if (doing === "" || doing === "making") return "";
  if (doing !== "busy") return t(`lanes.${doing}`);
  return behind > 0 ? n("lanes.behind", behind, format.count(behind)) : t("lanes.busy");
}

function expectedText({ from_at_s: fromS, to_at_s: toS }: NonNullable<Story["expected"]>, nowS: number): string {
  return t("lanes.expected", { from: format.due(fromS, nowS), to: format.due(toS, nowS) });
}

function titleOf(transport: Transport): string {
  return t("lanes.transport", {
    load: loadOf(transport.item, transport.quantity, transport.thing),
    from: placesOf(transport.source),
    to: placeOf(transport.destination),
  });
}

function carriersOf(transport: Transport): string {
  if (transport.legs.length === 0) return t("lanes.nobody");
  return transport.legs.map((leg) => (leg.replaced === "" ? leg.carrier : `${leg.carrier} ✕`)).join(" → ");
}
