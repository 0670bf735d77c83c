import { useComputed, useSignal, useSignalEffect } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { askAgain } from "../../../api/ask-again";
import { Icon } from "../../../parts/Icon";
import { choose, selection } from "../../../selection/selection";
import { format, t, word } from "../../../text/views/replay";
import { ticksOf } from "../../orders/page/lanes";
import { fetchSpells, type Told } from "./api";
import { doingText } from "./doing-text";
import type { Range } from "./film";
import { zoomedSpan } from "./links";
import { SpellStory } from "./SpellStory";
import { atS, past, seek } from "./state";
import { barsOf, byAgent, doneNow, type Spell } from "./strips";

/** Those that have a button of their own. */
const NAMED_S = { minute: 60, some: 720, hour: 3600, shift: 28_800 } as const;
/** Up to here the seconds of a moment tell something. */
const SECONDS_TO_S = 360;
const AGAIN_MS = 15_000;
const LEGEND = ["carries", "fetches", "waits", "charges", "idle", "makes", "starves", "blocked", "silent"] as const;

/** What everybody did in the minutes around the moment. */
export function Strips() {
  const spanS = useSignal<number>(NAMED_S.some);
  const whose = useSignal<"atvs" | "machines">("atvs");
  const told = useSignal<Told>({ items: [], isWhole: true });
  // The strips move in steps, so that not every picture asks anew.
  const range = useComputed<Range>(() => {
    const lengthS = spanS.value;
    const stepS = lengthS / 6;
    const middleS = (Math.floor(atS.value / stepS) + 0.5) * stepS;
    return { fromS: middleS - lengthS / 2, toS: middleS + lengthS / 2 };
  });
  const asked = useComputed(() => `${range.value.fromS} ${range.value.toS}`);
  useSignalEffect(() => {
    const [fromS = 0, toS = 0] = asked.value.split(" ").map(Number);
    return askAgain(() => fetchSpells({ fromS, toS }), (found) => { told.value = found; }, AGAIN_MS);
  });
  const found = useComputed(() => byAgent(told.value.items)).value;
  const zoom = (direction: "in" | "out"): void => {
    spanS.value = zoomedSpan(spanS.value, direction);
  };
  const agents = [...(whose.value === "atvs" ? (past.value?.atvs.keys() ?? []) : (past.value?.machines.keys() ?? []))].sort(inOrder);
  const { fromS, toS } = range.value;
  const left = (at: number): string => `${((at - fromS) / (toS - fromS)) * 100}%`;
  return (
    <div class="strips-card">
      <header class="card-head">
        <h2>{t("strips.title")}</h2>
        <div class="card-aside">
          <span class="segments" role="group" aria-label={t("strips.whose")}>
            {(["atvs", "machines"] as const).map((each) => (
              <button key={each} type="button" aria-pressed={whose.value === each} onClick={() => (whose.value = each)}>
                {t(`strips.whose.${each}`)}
              </button>
            ))}
          </span>
          <span class="segments" role="group" aria-label={t("strips.span")}>
            {(Object.keys(NAMED_S) as (keyof typeof NAMED_S)[]).map((each) => (
              <button key={each} type="button" aria-pressed={spanS.value === NAMED_S[each]} onClick={() => (spanS.value = NAMED_S[each])}>
                {t(`strips.span.${each}`)}
              </button>
            ))}
          </span>
          <span class="segments" role="group" aria-label={t("strips.zoom")}>
            {(["in", "out"] as const).map((each) => (
              <button key={each} type="button" aria-label={t(`strips.zoom.${each}`)} disabled={zoomedSpan(spanS.value, each) === spanS.value} onClick={() => { zoom(each); }}>
                <Icon name={each === "in" ? "plus" : "minus"} />
              </button>
            ))}
          </span>
        </div>
      </header>
      <p class="strip-hint faint">{t("strips.hint")}</p>
      <div
        class="strip-rows"
        tabIndex={0}
        role="group"
        aria-label={t("strips.keys")}
        onKeyDown={(event) => {
          if (event.target === event.currentTarget && onKey(event.key, spanS.value, zoom)) event.preventDefault();
        }}
        onWheel={(event) => {
          if (!event.ctrlKey && !event.metaKey && !(event.target as Element).closest(".strip-axis")) return;
          event.preventDefault();
          zoom(event.deltaY < 0 ? "in" : "out");
        }}
      >
        <div class="strip-row" aria-hidden="true">
          <span />
          <span class="strip-axis">
            {ticksOf({ fromS, toS }, 9).map((at) => (
              <i key={at} class="num" style={{ left: left(at) }}>
                {spanS.value <= SECONDS_TO_S ? format.clock(at) : format.hour(at)}
              </i>
            ))}
          </span>
        </div>
        {agents.map((agent) => (
          <Row key={agent} agent={agent} spells={found.get(agent) ?? []} range={range.value} />
        ))}
        <i class="strip-now" style={{ "--at": (atS.value - fromS) / (toS - fromS) }} aria-hidden="true" />
      </div>
      {!told.value.isWhole && <p class="replay-note tone-warn" role="status">{t("strips.notWhole")}</p>}
      <SpellStory spells={told.value.items} onLed={(kind) => (whose.value = kind === "atv" ? "atvs" : "machines")} />
      <p class="strip-legend" aria-hidden="true">
        {LEGEND.map((doing) => (
          <span key={doing}>
            <i class={`doing doing-${doing}`} /> {word("doing", doing)}
          </span>
        ))}
      </p>
    </div>
  );
}

function Row({ agent, range, spells }: { agent: string; range: Range; spells: readonly Spell[] }) {
  const now = doneNow(spells, atS.value);
  const kind = past.value?.atvs.has(agent) === true ? "atv" : "machine";
  const chosen = selection.value.atv === agent || selection.value.place?.id === agent;
  const row = useRef<HTMLDivElement>(null);
  useEffect(() => {
    // Within its list: what stands above the list stays where it is.
    const list = row.current?.parentElement;
    if (!chosen || !row.current || !list) return;
    const top = row.current.offsetTop;
    if (top < list.scrollTop) list.scrollTop = top;
    else if (top + row.current.offsetHeight > list.scrollTop + list.clientHeight) list.scrollTop = top + row.current.offsetHeight - list.clientHeight;
  }, [chosen]);
  const said = t("strips.at", { agent, at: format.clock(atS.value), doing: now ? doingText(now) : t("strips.none") });
  return (
    <div class={`strip-row ${chosen ? "chosen" : ""}`} ref={row}>
      <button type="button" class="link" aria-pressed={chosen} onClick={() => { choose({ kind, id: agent }); }}>
        {agent}
      </button>
      <span
        class="strip-track"
        role="img"
        aria-label={said}
        onClick={(event) => {
          const box = event.currentTarget.getBoundingClientRect();
          if (!chosen) choose({ kind, id: agent });
          seek(range.fromS + ((event.clientX - box.left) / box.width) * (range.toS - range.fromS));
        }}
      >
        {barsOf(spells, range).map(({ left, spell, width }) => (
          <i key={`${spell.from_at_s}`} class={`doing doing-${spell.doing}`} style={{ left: `${left}%`, width: `${width}%` }} title={doingText(spell)}>
            {width > 4 ? doingText(spell) : ""}
          </i>
        ))}
      </span>
    </div>
  );
}

/** Keys on the strips as a whole; whether it is one of them. */
function onKey(key: string, spanS: number, zoom: (direction: "in" | "out") => void): boolean {
  if (key === "+" || key === "=") zoom("in");
  else if (key === "-") zoom("out");
  else if (key === "ArrowLeft" || key === "ArrowRight") seek(atS.peek() + (key === "ArrowLeft" ? -1 : 1) * (spanS / 60));
  else return false;
  return true;
}

/** ATV2 before ATV10. */
function inOrder(a: string, b: string): number {
  return a.localeCompare(b, undefined, { numeric: true });
}
