import type { TaskView } from "../../api/types";
import { Tag } from "../../parts/Tag";
import { freshness, world } from "../../stream/stream";
import { isPast } from "../../stream/freshness";
import { format, t } from "../../text/operator";
import { placeOf } from "../../text/place";
import { CommandLine } from "../commands/CommandLine";
import { sayLoad } from "../commands/given";
import { HoldButton } from "../cards/HoldButton";
import { ended } from "../session/session";
import { names } from "../state";
import { heldOf } from "./held";

/** Loads that are perhaps there and not counted: somebody looks, and says what is there. Either is held, for nothing takes it back. */
export function HeldCards() {
  const tasks = heldOf(world.value?.tasks.values() ?? []);
  if (tasks.length === 0) return null;
  return (
    <ul class="cards needing" aria-label={t("held.label")}>
      {tasks.map((task) => (
        <HeldCard key={task.id} task={task} />
      ))}
    </ul>
  );
}

function HeldCard({ task }: { task: TaskView }) {
  const { coordinator, id } = task;
  const disabled = ended.value !== null || isPast(freshness.value) || freshness.value === "connecting";
  return (
    <li class="vehicle card machine-need need-help" id={`held-${id}`}>
      <div class="vehicle-body">
        <header>
          <h2>{t("held.title", { place: placeOf(task.destination) })}</h2>
          <Tag tone="warn">{id}</Tag>
        </header>
        <div class="vehicle-now">
          <p class="help-what">{heldText(task)}</p>
          <p class="doing">{t("held.look")}</p>
        </div>
        <div class="vehicle-acts">
          {([true, false] as const).map((there) => (
            <HoldButton key={String(there)} class="button fault-gone" disabled={disabled} onHeld={() => void sayLoad(coordinator, id, there)}>
              <b>{t(there ? "command.load_there" : "command.load_missing")}</b>
              <small>{t(there ? "held.more.there" : "held.more.missing")}</small>
            </HoldButton>
          ))}
        </div>
        <CommandLine atv={coordinator} stopped={false} />
      </div>
    </li>
  );
}

/** What is to be looked for, and where. */
export function heldText({ destination: place, item, quantity }: TaskView): string {
  return t("held.what", { quantity: format.count(quantity), item: names.value(item), place: placeOf(place) });
}
