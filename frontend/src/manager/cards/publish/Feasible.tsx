import { useSignalEffect } from "@preact/signals";
import type { MaterialNeed, OrderPreview } from "../../../api/types";
import { Tag } from "../../../parts/Tag";
import { nowS, world } from "../../../stream/stream";
import { format, n, t } from "../../../text/manager";
import { HERE } from "../../parts/Linked";
import { names, plant } from "../../state";
import { addressOf } from "../../views";
import { makersOf, needsOf, quantityOf, unableOf } from "./draft";
import { draft, outcome } from "./form";
import { Needs, NeedsButton } from "./Needs";
import { followDraft, preview } from "./preview";
import { factoryTime } from "../../../text/plant-time";

/** As many as fit into a line or two. */
const MOST_NAMED = 6;

/** Who can make it, when it would be there and what has to be brought for it; after sending, what came of it. */
export function Feasible() {
  useSignalEffect(followDraft);
  const file = plant.value;
  if (!file) return null;
  if (outcome.value) {
    const { good, hints = [], order, text } = outcome.value;
    const [before, after = ""] = text.split(HERE);
    return (
      <>
        <p class={`outcome outcome-${good ? "good" : "bad"}`}>
          {before}
          {order !== undefined && <a class="link" href={addressOf(order)}>{order}</a>}
          {after}
        </p>
        {hints.map((hint) => (
          <p key={hint} class="tone-warn">{hint}</p>
        ))}
      </>
    );
  }
  if (preview.value) return <Foreseen found={preview.value} />;
  const { product } = draft.value;
  if (product === "") return null;
  const makers = makersOf(file, product);
  const cycle = factoryTime(Math.min(...makers.map(({ cycleS }) => cycleS)));
  return (
    <>
      <p>{makers.length === 0 ? t("publish.nobody") : t("publish.machines", { machines: named(makers.map(({ id }) => id)), cycle })}</p>
      <ul>
        {needsOf(file, product, quantityOf(draft.value)).map(({ name, pieces, lots }) => (
          <li key={name}>
            <b>{format.count(pieces)}</b> {name} <span class="faint">{n("publish.lots", lots, format.count(lots))}</span>
          </li>
        ))}
      </ul>
    </>
  );
}

function Foreseen({ found }: { found: OrderPreview }) {
  const able = found.machines.filter(({ available }) => available);
  const { lost, unheard } = unableOf(found.machines, world.value?.machines ?? new Map<string, unknown>());
  const free = Math.min(...able.map(({ queue_s }) => queue_s));
  return (
    <>
      <p>
        {able.length === 0
          ? t(found.machines.length === 0 ? "publish.nobody" : "publish.nobodyNow")
          : t(free < 1 ? "publish.freeNow" : "publish.freeIn", { machines: named(able.map(({ machine }) => machine)), free: factoryTime(free, world.value?.factory.speed ?? 1) })}
        {lost > 0 && <span class="tone-warn"> · {n("publish.lostMachines", lost)}</span>}
        {unheard > 0 && <span class="muted"> · {n("publish.unheardMachines", unheard)}</span>}
      </p>
      {found.earliest_at_s !== null && found.latest_at_s !== null && (
        <p>
          {t("publish.there", { from: format.due(found.earliest_at_s, nowS.value), to: format.due(found.latest_at_s, nowS.value) })}
          {found.late !== "" && <> <Tag tone="warn">{t(found.late === "yes" ? "publish.late" : "publish.maybeLate")}</Tag></>}
        </p>
      )}
      <ul>
        {found.materials.map((need) => (
          <Need key={need.material} need={need} />
        ))}
        <li>
          <NeedsButton />
        </li>
      </ul>
      <Needs found={found} />
    </>
  );
}

function Need({ need }: { need: MaterialNeed }) {
  return (
    <li>
      <b>{format.count(need.needed)}</b> {names.value(need.material)}{" "}
      <span class="faint">{n("publish.lots", need.loads, format.count(need.loads))}</span>
      {need.refills && <span class="tone-warn"> {t("publish.refills")}</span>}
    </li>
  );
}

function named(machines: readonly string[]): string {
  const first = machines.slice(0, MOST_NAMED);
  const others = machines.length - first.length;
  return format.list(others > 0 ? [...first, n("publish.others", others)] : first);
}
