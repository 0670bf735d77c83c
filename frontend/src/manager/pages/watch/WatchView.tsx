import { signal, useComputed } from "@preact/signals";
import type { AtvView } from "../../../api/types";
import { Meter } from "../../../parts/Meter";
import { Table } from "../../../parts/Table";
import { Tag, type Tone } from "../../../parts/Tag";
import { boundS } from "../../../plant/silence";
import { presentS, world } from "../../../stream/stream";
import { sinceHeardIn } from "../../../text/heard";
import { inFactoryTime } from "../../../text/plant-time";
import { speakAlso } from "../../../text/speech";
import { format, t, tables, word } from "../../../text/views/records";
import { linkText } from "../../cards/atv/link";
import { Search } from "../../parts/filters/Search";
import { ShowLink } from "../../parts/ShowLink";
import { names } from "../../state";
import { type Filter, FILTERS, isExposed, isFound, passes, type Watched, watches, type WatchState } from "./watch";

const filter = signal<Filter>("all");
const words = signal("");

const TONES: Readonly<Record<WatchState, Tone>> = {
  silent: "alarm", overdue: "warn", unwatched: "normal", watched: "normal",
};

/** The view, once it has its words. */
export async function load(): Promise<typeof WatchView> {
  await speakAlso(tables);
  return WatchView;
}

/** Who watches whom, and how long ago the watched one was heard. */
export function WatchView() {
  const all = useComputed(() => (world.value ? watches(world.value, presentS.value) : [])).value;
  const shown = all.filter((each) => passes(each, filter.value) && isFound(each, words.value));
  const heads = ["carrier", "age", "secondary", "secondaryAge", "doing", "task", "for"] as const;
  return (
    <Table
      title={t("watch.title")}
      hint={t("watch.hint")}
      heads={heads.map((head) => (head === "age" || head === "secondaryAge" ? inFactoryTime(t(`watch.${head}`)) : t(`watch.${head}`)))}
      empty={t(all.length === 0 ? "watch.none" : "watch.noneOf")}
      aside={<Filters all={all} />}
    >
      {shown.map((each) => (
        <Row key={each.task.id} watched={each} />
      ))}
    </Table>
  );
}

function Filters({ all }: { all: readonly Watched[] }) {
  return (
    <>
      <Search words={words} />
      <div class="segments" role="group" aria-label={t("watch.show")}>
        {FILTERS.map((each) => (
          <button
            key={each}
            type="button"
            aria-pressed={filter.value === each}
            onClick={() => {
              filter.value = each;
            }}
          >
            {t(`watch.${each}`)} <span class="num faint">{all.filter((one) => passes(one, each)).length}</span>
          </button>
        ))}
      </div>
    </>
  );
}

function Row({ watched }: { watched: Watched }) {
  const { aboard, carrier, secondary, state, task } = watched;
  return (
    <tr>
      <th scope="row">
        <Vehicle id={task.primary} />
        {(state === "silent" || state === "overdue") && (
          <>
            {" "}
            <Tag tone={TONES[state]}>{word("watch.state", state)}</Tag>
          </>
        )}
      </th>
      <td>{carrier && <Age atv={carrier} />}</td>
      <td>
        {task.secondary !== "" ? (
          <Vehicle id={task.secondary} strong />
        ) : aboard ? (
          <span class="muted" title={t("watch.aboardHint")}>{t("watch.aboard")}</span>
        ) : (
          <span class={isExposed(watched) ? "tone-warn" : "muted"}>{t("watch.nobody")}</span>
        )}
      </td>
      <td>{secondary && <Age atv={secondary} />}</td>
      <td>{task.phase && word("phase", task.phase)}</td>
      <td>
        <ShowLink chosen={{ kind: "task", id: task.id }} label={t("tasks.open", { id: task.id })} />
      </td>
      <td>
        {task.coordinator}
        <span class="muted">
          {" · "}
          {t("auction.what", { quantity: format.count(task.quantity), item: names.value(task.item) })}
        </span>
      </td>
    </tr>
  );
}

function Vehicle({ id, strong = false }: { id: string; strong?: boolean }) {
  const link = <ShowLink chosen={{ kind: "atv", id }} label={t("watch.open", { id })} />;
  return strong ? <b>{link}</b> : link;
}

/** How long ago it was heard, to the scale of the silence that would count as failure. */
function Age({ atv }: { atv: AtvView }) {
  const ageS = Math.max(0, presentS.value - atv.seen_at_s);
  const bound = boundS(atv, world.value?.factory.speed ?? 1);
  const age = sinceHeardIn(ageS);
  const lost = ageS > bound;
  return (
    <span class="age">
      <Meter
        frac={ageS / bound}
        tone={lost ? "alarm" : ageS > bound / 2 ? "warn" : "normal"}
        label={t("watch.ageLabel", { age, bound: sinceHeardIn(bound) })}
      />
      <span class={`num ${lost ? "tone-alarm" : ""}`}>{age}</span>
      {atv.link === "mesh" && !lost && <Tag tone="warn">{linkText(atv)}</Tag>}
    </span>
  );
}
