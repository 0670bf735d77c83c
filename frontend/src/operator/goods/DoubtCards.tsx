import { freshness, world } from "../../stream/stream";
import { isPast } from "../../stream/freshness";
import { vehicleName } from "../../text/elsewhere";
import { format, t } from "../../text/operator";
import { placeOf } from "../../text/place";
import { HoldButton } from "../cards/HoldButton";
import { CommandLine } from "../commands/CommandLine";
import { sayCounted } from "../commands/given";
import { ended } from "../session/session";
import { names } from "../state";
import { type Doubt, doubtsOf } from "./doubts";

/** Loads of which nobody can tell: somebody counts, and says what is there. Either is held, for nothing takes it back. */
export function DoubtCards() {
  const doubts = world.value === null ? [] : doubtsOf(world.value);
  if (doubts.length === 0) return null;
  return (
    <ul class="cards needing" aria-label={t("held.label")}>
      {doubts.map((doubt) => (
        <DoubtCard key={doubt.load} doubt={doubt} />
      ))}
    </ul>
  );
}

function DoubtCard({ doubt }: { doubt: Doubt }) {
  const { item, level, load, place, quantity } = doubt;
  const disabled = ended.value !== null || isPast(freshness.value) || freshness.value === "connecting";
  const pieces = { level: format.count(level), more: format.count(level + quantity) };
  return (
    <li class="vehicle card machine-need need-help" id={`doubt-${load}`}>
      <div class="vehicle-body">
        <header>
          <h2>{t("doubt.title", { item: names.value(item), place: placeOf(place) })}</h2>
        </header>
        <div class="vehicle-now">
          <p class="help-what">{doubtText(doubt)}</p>
          <p class="doing">{t("doubt.count", pieces)}</p>
        </div>
        <div class="vehicle-acts">
          {([true, false] as const).map((there) => (
            <HoldButton key={String(there)} class="button fault-gone" disabled={disabled} onHeld={() => void sayCounted(doubt, there)}>
              <b>{t(there ? "doubt.there" : "doubt.missing", pieces)}</b>
              <small>{t(there ? "doubt.more.there" : "doubt.more.missing")}</small>
            </HoldButton>
          ))}
        </div>
        <CommandLine atv={place} stopped={false} />
      </div>
    </li>
  );
}

/** What perhaps lies where. */
export function doubtText({ brought, item, place, quantity, vehicle }: Doubt): string {
  const what = { quantity: format.count(quantity), item: names.value(item), place: placeOf(place), atv: vehicleName(vehicle) };
  return t(brought ? "doubt.brought" : "doubt.taken", what);
}
