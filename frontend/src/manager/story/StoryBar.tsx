import { useSignal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import type { TaskView } from "../../api/types";
import { Link } from "../../parts/Link";
import { lastChosen, NOTHING, selection } from "../../selection/selection";
import { world } from "../../stream/stream";
import { format, t } from "../../text/manager";
import { names, orderName, placeOf, taskName } from "../state";
import { addressOf, addressOfTransport, storyOf as pageOf, transportOf } from "../views";
import { follow, following } from "./address";
import { isUnknown, storyOf, taskOfStory } from "./story";
import { Term } from "./Term";

/** What belongs together of what was chosen, in one line: each part of it can be chosen, and all of it be followed and sent. */
export function StoryBar() {
  const chosen = lastChosen(selection.value);
  if (chosen === null || isUnknown(world.value, chosen)) {
    return (
      <section class="story card" aria-label={t("story.label")}>
        <p class="muted">{chosen === null ? t("story.none") : t("story.unknown", { id: chosen.id })}</p>
      </section>
    );
  }
  // As it is now: the cards and the map stay with what was chosen, unless they are to go along.
  const story = storyOf(world.value, NOTHING, chosen);
  const task = world.value && taskOfStory(world.value, story);
  const { order, place, standby } = story;
  const isTransport = task?.kind === "transport";
  const called = transportOf(task?.id ?? "");
  // Who watches over it may be the chosen one; the story is the carrier's.
  const atv = standby !== null && task ? task.primary : story.atv;
  return (
    <section class="story card" aria-label={t("story.label")}>
      <dl>
        {task && (
          <Part name={t(isTransport ? "story.transport" : "story.production")}>
            <Link kind="task" id={task.id} name={taskName(task.id, task.order)} />
            <What task={task} />
          </Part>
        )}
        {atv !== null && <Part name={t("story.vehicle")}><Link kind="atv" id={atv} /></Part>}
        {standby !== null && <Part name={<Term name="standby">{t("story.standby")}</Term>}><Link kind="atv" id={standby} /></Part>}
        {place !== null && <Part name={t(place.kind === "machine" ? "story.machine" : "story.place")}><Link kind={place.kind} id={place.id} name={placeOf(place.id)} /></Part>}
        {called !== "" && (
          <Part name={t("story.called")}>
            <a class="link" href={addressOfTransport(called)}>{called}</a>
          </Part>
        )}
        {order !== null && (
          <Part name={t("story.order")}>
            <a class="link" href={addressOf(order)}>{orderName(order)}</a>
          </Part>
        )}
      </dl>
      <div class="story-acts">
        <button type="button" class="button small" aria-pressed={following.value} title={t("story.followTitle")} onClick={() => { follow(!following.value); }}>
          {t("story.follow")}
        </button>
        <CopyLink />
      </div>
    </section>
  );
}

function Part({ children, name }: { name: ComponentChildren; children: ComponentChildren }) {
  return (
    <div>
      <dt>{name}</dt>
      <dd>{children}</dd>
    </div>
  );
}

/** The address says what is chosen; where nothing may be put on the clipboard it can be taken from the address bar. */
function CopyLink() {
  const done = useSignal<"" | "story.copied" | "story.notCopied">("");
  const copy = async (): Promise<void> => {
    try {
      await navigator.clipboard.writeText(location.href);
      done.value = "story.copied";
    } catch {
      done.value = "story.notCopied";
    }
  };
  return (
    <>
      <button type="button" class="button small" onClick={() => void copy()}>{t("story.copy")}</button>
      {done.value !== "" && <small class="muted" role="status">{t(done.value)}</small>}
    </>
  );
}

/** What is carried or made in it, with the way to where its story is told; a plain transport has its own beside it. */
function What({ task }: { task: TaskView }) {
  const what = t("auction.what", { quantity: format.count(task.quantity), item: names.value(task.item) });
  const page = transportOf(task.id) === "" ? pageOf(task) : "";
  return page === "" ? <span class="muted">{what}</span> : <a class="link" href={page}>{what}</a>;
}
