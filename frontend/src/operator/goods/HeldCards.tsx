import type { TaskView } from "../../api/types";
import { world } from "../../stream/stream";
import { format, t } from "../../text/operator";
import { placeOf } from "../../text/place";
import { sayLoad } from "../commands/given";
import { HoldButton } from "../cards/HoldButton";
import { names } from "../state";
import { heldOf } from "./held";
import { isMute, LoadCard } from "./LoadCard";

/** Loads that are perhaps there and not counted, and docks where vehicles fail: somebody looks, and says what is there. Either is held, for nothing takes it back. */
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
  return (
    <LoadCard id={`held-${id}`} title={titleText(task)} tag={id} what={heldText(task)} look={lookText(task)} asker={coordinator}>
      {answersOf(task).map(({ there, what, more }) => (
        <HoldButton key={String(there)} class="button fault-gone" disabled={isMute()} onHeld={() => void sayLoad(coordinator, id, there)}>
          <b>{what}</b>
          <small>{more}</small>
        </HoldButton>
      ))}
    </LoadCard>
  );
}

/** What somebody may have seen; at a dock where vehicles fail, the load is at its destination only if people have brought it. */
function answersOf({ fails_at }: TaskView) {
  if (fails_at !== "") {
    return [
      { there: false, what: t("held.dock.inOrder"), more: t("held.dock.more.inOrder") },
      { there: true, what: t("held.dock.byHand"), more: t("held.dock.more.byHand") },
    ];
  }
  return [
    { there: true, what: t("command.load_there"), more: t("held.more.there") },
    { there: false, what: t("command.load_missing"), more: t("held.more.missing") },
  ];
}

function titleText({ destination, fails_at }: TaskView): string {
  return fails_at === "" ? t("held.title", { place: placeOf(destination) }) : t("held.dock.title", { place: placeOf(fails_at) });
}

/** What is to be looked for, and where. */
export function heldText({ destination, fails_at, item, quantity }: TaskView): string {
  const load = { quantity: format.count(quantity), item: names.value(item) };
  return fails_at === "" ? t("held.what", { ...load, place: placeOf(destination) }) : t("held.dock.what", load);
}

export function lookText({ fails_at }: TaskView): string {
  return t(fails_at === "" ? "held.look" : "held.dock.look");
}
