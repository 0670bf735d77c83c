import { choose, selection } from "../../../selection/selection";
import { format, t } from "../../../text/views/replay";
import { doingText } from "./doing-text";
import { linksOf, spellBeside, type SpellLink } from "./links";
import { atS, past, seek } from "./state";
import { doneNow, type Spell } from "./strips";

interface Props {
  /** Of everybody. */
  readonly spells: readonly Spell[];
  /** The strips that somebody is led to are shown. */
  readonly onLed: (kind: "atv" | "machine") => void;
}

/** What the chosen vehicle or machine did at the moment, from when to when, and whom that leads to. */
export function SpellStory({ onLed, spells }: Props) {
  const chosen = [selection.value.atv, selection.value.place?.id].filter((each) => each != null && isShown(each));
  if (chosen.length === 0) return <p class="spell-story muted">{t("spell.choose")}</p>;
  return (
    <div class="spell-story">
      {chosen.map((agent) => (
        <Told key={agent} agent={agent ?? ""} spells={spells} onLed={onLed} />
      ))}
    </div>
  );
}

function Told({ agent, onLed, spells }: Props & { agent: string }) {
  const own = spells.filter((each) => each.agent === agent);
  const now = doneNow(own, atS.value);
  const before = spellBeside(own, atS.value, -1);
  const next = spellBeside(own, atS.value, 1);
  const links = now ? linksOf(now, spells, new Set([...(past.value?.atvs.keys() ?? []), ...(past.value?.machines.keys() ?? [])])) : [];
  const go = (to: Spell | undefined): void => {
    if (to) seek(to.from_at_s);
  };
  return (
    <section aria-label={t("spell.of", { agent })}>
      <p role="status">
        <b>{agent}</b> {now ? t("spell.says", { doing: doingText(now), from: format.clock(now.from_at_s), until: format.clock(now.until_at_s), time: format.duration(now.until_at_s - now.from_at_s) }) : t("strips.none")}
      </p>
      <span class="spell-acts">
        <button type="button" class="button small" disabled={!before} onClick={() => { go(before); }}>
          {t("spell.before")}
        </button>
        <button type="button" class="button small" disabled={!next} onClick={() => { go(next); }}>
          {t("spell.next")}
        </button>
        {links.map((link) => (
          <button key={`${link.kind} ${link.agent}`} type="button" class="button small spell-link" onClick={() => { lead(link, onLed); }}>
            {t(`spell.${link.kind}`, { other: link.agent })} <span class="muted num">{format.clock(link.atS)}</span>
          </button>
        ))}
      </span>
    </section>
  );
}

/** To the other one, at that moment. */
function lead({ agent, atS: toS }: SpellLink, onLed: Props["onLed"]): void {
  const kind = past.peek()?.atvs.has(agent) === true ? "atv" : "machine";
  choose({ kind, id: agent });
  onLed(kind);
  seek(toS);
}

function isShown(agent: string): boolean {
  return past.value?.atvs.has(agent) === true || past.value?.machines.has(agent) === true;
}
