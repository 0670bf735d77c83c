import { useSignal } from "@preact/signals";
import { Tag } from "../../../parts/Tag";
import { nowS } from "../../../stream/stream";
import { format, t } from "../../../text/views/order";
import { usePrinting } from "../../parts/paper/printing";
import { MomentLink } from "../../replay/MomentLink";
import { chooseTransport, chosenTransport, FILTERS, wantedEvents, wantEvents } from "./address";
import { isProblem, isWanted, type Moment, momentText } from "./moments";

/** Before somebody asks for more. */
const AT_FIRST = 40;

/** What happened, newest first; one selection with the lanes. `partly` says that it is not all; empty where it is. */
export function Moments({ moments, partly }: { moments: readonly Moment[]; partly: string }) {
  const chosen = chosenTransport.value;
  const all = useSignal(false);
  const printing = usePrinting();
  const fitting = moments.filter((moment) => isWanted(moment, wantedEvents.value)).reverse();
  const shown = all.value || printing.value ? fitting : fitting.slice(0, AT_FIRST);
  return (
    <section class="card order-moments" aria-labelledby="order-moments">
      <header class="card-head">
        <h2 id="order-moments">{t("moments.title")}</h2>
        <span class="count">{t("moments.count", { n: format.count(fitting.length) })}</span>
        <div class="card-aside">
          <span class="segments" role="group" aria-label={t("moments.show")}>
            {FILTERS.map((each) => (
              <button key={each} type="button" aria-pressed={wantedEvents.value === each} onClick={() => { wantEvents(each); }}>
                {t(`moments.${each}`)}
              </button>
            ))}
          </span>
        </div>
      </header>
      {partly !== "" && <p class="table-hint">{partly}</p>}
      {fitting.length === 0 && <p class="empty">{t("moments.none")}</p>}
      <ol>
        {shown.map((moment, index) => (
          <li key={`${moment.at_s}-${moment.kind}-${moment.task}-${index}`} class={moment.task !== "" && moment.task === chosen ? "chosen" : ""}>
            <time class="num muted" dateTime={new Date(moment.at_s * 1000).toISOString()}>
              {format.when(moment.at_s, nowS.value)}
            </time>
            <span>
              <Tag tone={isProblem(moment) ? "warn" : "normal"}>{t(`moments.kind.${moment.kind}`)}</Tag>
            </span>
            {moment.task === "" ? (
              <span>{momentText(moment)}</span>
            ) : (
              <button type="button" class="moment-text" aria-pressed={moment.task === chosen} onClick={() => { chooseTransport(moment.task); }}>
                {momentText(moment)}
              </button>
            )}
            <MomentLink atS={moment.at_s} about={momentText(moment)} />
          </li>
        ))}
      </ol>
      {shown.length < fitting.length && (
        <p class="empty">
          <button type="button" class="button small" onClick={() => (all.value = true)}>
            {t("moments.more", { n: format.count(fitting.length - shown.length) })}
          </button>
        </p>
      )}
    </section>
  );
}
