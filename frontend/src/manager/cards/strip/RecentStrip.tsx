import { useComputed, useSignal, useSignalEffect } from "@preact/signals";
import { askAgain } from "../../../api/ask-again";
import { fetchSpells } from "../../replay/page/api";
import { doingText } from "../../replay/page/doing-text";
import { barsOf, type Spell } from "../../replay/page/strips";
import { addressOfMoment } from "../../views";
import "../../replay/page/replay.css";
import { stateOf } from "../../pages/shift/report/shifts";
import { selection } from "../../../selection/selection";
import { nowS } from "../../../stream/stream";
import { speakAlso } from "../../../text/speech";
import { tables as replayTables } from "../../../text/views/replay";
import { format, t, tables, word } from "../../../text/views/shift";
import "./recent.css";

const SPAN_S = 1800;
const AGAIN_MS = 5_000;
/** The strips of everybody begin with what has just been. */
const AGO_S = 5;

async function speak(): Promise<void> {
  await Promise.all([speakAlso(replayTables), speakAlso(tables)]);
}

/** The strip of the chosen vehicle, once it has its words. */
export async function loadAtv(): Promise<typeof OfAtv> {
  await speak();
  return OfAtv;
}

/** The same of the chosen machine. */
export async function loadMachine(): Promise<typeof OfMachine> {
  await speak();
  return OfMachine;
}

function OfAtv() {
  const agent = selection.value.atv ?? "";
  return agent === "" ? null : <RecentStrip key={agent} agent={agent} kind="atv" />;
}

function OfMachine() {
  const agent = selection.value.place?.id ?? "";
  return agent === "" ? null : <RecentStrip key={agent} agent={agent} kind="machine" />;
}

/** What one vehicle or machine did in the last half hour; the newest is at the right. */
function RecentStrip({ agent, kind }: { agent: string; kind: "atv" | "machine" }) {
  const spells = useSignal<readonly Spell[]>([]);
  const isKnown = useSignal(false);
  // Half a minute is a pixel: that it moves every second would only cost.
  const toS = useComputed(() => Math.ceil(nowS.value / 5) * 5);
  useSignalEffect(() => {
    const fetch = (): ReturnType<typeof fetchSpells> => fetchSpells({ fromS: nowS.peek() - SPAN_S, toS: nowS.peek() }, agent);
    return askAgain(fetch, ({ items }) => {
      spells.value = items;
      isKnown.value = true;
    }, AGAIN_MS);
  });
  if (!isKnown.value) return null;
  const range = { fromS: toS.value - SPAN_S, toS: toS.value };
  const bars = barsOf(spells.value, range);
  return (
    <div class="recent">
      <p class="recent-head">
        {t("recent.title")} <span class="muted">{format.hour(range.fromS)} – {format.hour(range.toS)}</span>{" "}
        <a class="link" href={addressOfMoment(nowS.value - AGO_S)} aria-label={t("recent.timelineOf", { agent })}>
          {t("recent.timeline")}
        </a>
      </p>
      <span class="strip-track recent-track" role="img" aria-label={t("recent.label", { agent, doings: toldOf(spells.value, range.fromS) })}>
        {bars.map(({ left, spell, width }) => (
          <i
            key={`${spell.from_at_s}`}
            class={`doing doing-${spell.doing}`}
            style={{ left: `${left}%`, width: `${width}%` }}
            title={`${format.clock(spell.from_at_s)} ${doingText(spell)} (${word("shift.state", stateOf(kind, spell.doing))})`}
          />
        ))}
      </span>
    </div>
  );
}

/** How long each was done, the longest first. */
function toldOf(spells: readonly Spell[], fromS: number): string {
  const spent = new Map<string, number>();
  for (const { doing, from_at_s, until_at_s } of spells) spent.set(doing, (spent.get(doing) ?? 0) + until_at_s - Math.max(from_at_s, fromS));
  const told = [...spent].sort((a, b) => b[1] - a[1]);
  return told.length === 0 ? t("shift.unknown") : format.list(told.map(([doing, spentS]) => `${word("doing", doing)} ${format.duration(spentS)}`));
}
