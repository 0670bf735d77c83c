import { useSignal } from "@preact/signals";
import { Card } from "../../../parts/Card";
import { nowS } from "../../../stream/stream";
import { format, t } from "../../../text/views/order";
import { usePrinting } from "../../parts/paper/printing";
import { names, orderName } from "../../state";
import { addressOf } from "../../views";
import { dueOnBand, type Estimate, heightOf, labelsOf, leftOf, linesOf, type Move, movesOf, stepsOf, timeOf, topOf } from "./estimates";
import type { Story } from "./lanes";

/** What is shorter is told to the second. */
const FINE_S = 300;

/** The newest, before somebody asks for more. */
const AT_FIRST = 5;

interface Props {
  estimates: readonly Estimate[];
  dueS: number | null;
  deliveredS: number | null;
  /** Now, or the order's end. */
  untilS: number;
  hasEnded: boolean;
  /** When all of it is expected now; null where nobody can tell, and after the end. */
  expected: Story["expected"];
}

/** How the expected time has moved, as a band, and below it why. */
export function EstimatesCard({ deliveredS, dueS, estimates, expected, hasEnded, untilS }: Props) {
  const all = useSignal(false);
  const printing = usePrinting();
  if (estimates.length === 0) return null;
  const moves = movesOf(estimates);
  const hidden = all.value || printing.value ? 0 : Math.max(0, moves.length - AT_FIRST);
  const shown = moves.slice(hidden);
  return (
    <Card title={t("estimates.title")} class="order-estimates">
      <Band estimates={estimates} dueS={dueS} deliveredS={deliveredS} hasEnded={hasEnded} untilS={untilS} shown={shown} first={hidden + 1} />
      {moves.length === 0 && <p class="muted">{stayedText(estimates, expected)}</p>}
      {hidden > 0 && (
        <button type="button" class="button small" onClick={() => (all.value = true)}>
          {t("moments.more", { n: format.count(hidden) })}
        </button>
      )}
      <ol start={hidden + 1}>
        {shown.map((move) => (
          <li key={move.estimate.at_s}>
            <time class="num muted" dateTime={new Date(move.estimate.at_s * 1000).toISOString()}>
              {format.when(move.estimate.at_s, nowS.value)}
            </time>{" "}
            {move.estimate.cause === "passed" ? <a class="link" href={addressOf(move.estimate.other)}>{moveText(move)}</a> : moveText(move)}
          </li>
        ))}
      </ol>
    </Card>
  );
}

/** Small moves are not kept: where the last one that is kept is not what is expected now, that is told. */
export function stayedText(estimates: readonly Estimate[], expected: Story["expected"]): string {
  const kept = estimates.at(-1);
  if (expected === null || (kept?.from_at_s === expected.from_at_s && kept.to_at_s === expected.to_at_s)) return t("estimates.stayed");
  return t("estimates.nearly", { from: format.due(expected.from_at_s, nowS.value), to: format.due(expected.to_at_s, nowS.value) });
}

function Band({ deliveredS, dueS: orderDueS, estimates, first, hasEnded, shown, untilS }: Omit<Props, "expected"> & { shown: readonly Move[]; first: number }) {
  const time = timeOf(estimates, untilS, hasEnded);
  const clock = time.toS - time.fromS < FINE_S ? format.clock : format.hour;
  const dueS = dueOnBand(estimates, orderDueS, deliveredS, hasEnded);
  const height = heightOf(estimates, [dueS, deliveredS]);
  const at = (atS: number) => ({ left: `${leftOf(time, atS)}%` });
  const lines = linesOf(shown.map(({ estimate }) => leftOf(time, estimate.at_s)));
  const raised = Math.max(0, ...lines.map((line) => line ?? 0));
  const top = (atS: number) => ({ top: `${topOf(height, atS)}%` });
  const known = estimates.flatMap(({ from_at_s, to_at_s }) => [from_at_s, to_at_s].filter((atS) => atS !== null));
  const ends = known.length === 0 ? [] : [Math.min(...known), Math.max(...known)];
  return (
    <div class="estimates" role="img" aria-label={bandText(estimates)} style={{ "--lines": raised }}>
      <span class="estimates-scale num" aria-hidden="true">
        {labelsOf(ends, height).map(({ atS, topPercent }) => (
          <i key={atS} style={{ top: `${topPercent}%` }}>{format.hour(atS)}</i>
        ))}
      </span>
      <span class="estimates-band">
        {stepsOf(estimates, time, height, untilS).map((step) => (
          <i
            key={step.leftPercent}
            class="estimates-step"
            style={{ left: `${step.leftPercent}%`, width: `${step.widthPercent}%`, top: `${step.topPercent}%`, height: `${step.heightPercent}%` }}
          />
        ))}
        {dueS !== null && (
          <i class="estimates-due" style={top(dueS)}>
            <small>{t("lanes.legend.due")}</small>
          </i>
        )}
        {shown.map(({ estimate }, index) => (
          <i key={estimate.at_s} class="estimates-move" style={at(estimate.at_s)}>
            {lines[index] != null && <small class="num" style={{ "--line": lines[index] }}>{first + index}</small>}
          </i>
        ))}
        {deliveredS !== null && <i class="estimates-end" style={{ ...at(deliveredS), ...top(deliveredS) }} />}
      </span>
      <span class="estimates-time num" aria-hidden="true">
        <i>{clock(time.fromS)}</i>
        <i>{clock(time.toS)}</i>
      </span>
    </div>
  );
}

/** What the band shows, for who does not see it: the first and the last of it. */
function bandText(estimates: readonly Estimate[]): string {
  const told = estimates.filter(({ to_at_s }) => to_at_s !== null);
  const text = (estimate: Estimate | undefined): string =>
    estimate?.from_at_s == null || estimate.to_at_s === null
      ? t("orderPage.unknown")
      : t("orderPage.range", { from: format.due(estimate.from_at_s, nowS.value), to: format.due(estimate.to_at_s, nowS.value) });
  return t("estimates.label", { first: text(told[0]), last: text(told.at(-1)) });
}

/** Why it moved, by name, and by how much. */
export function moveText({ byS, estimate }: Move): string {
  const { agent, cause, other } = estimate;
  const because = {
    agent,
    other: cause === "material" ? names.value(other) : cause === "passed" ? orderName(other) : other,
  };
  const text = t(other === "" && (cause === "moved" || cause === "replaced") ? `estimates.${cause}.nobody` : `estimates.${cause}`, because);
  if (estimate.to_at_s === null) return t("estimates.untold", { text });
  if (byS === null || byS === 0) return text;
  return t(byS > 0 ? "estimates.by.later" : "estimates.by.sooner", { text, time: format.duration(Math.abs(byS)) });
}
