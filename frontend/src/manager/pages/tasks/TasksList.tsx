import { computed, useComputed } from "@preact/signals";
import { fetchTasks, type TaskRecord } from "../../../api/client";
import type { TaskView } from "../../../api/types";
import { Table } from "../../../parts/Table";
import { nowS, world } from "../../../stream/stream";
import { causeText } from "../../../text/failure";
import { speakAlso } from "../../../text/speech";
import { format, t, tables, word } from "../../../text/views/records";
import { isOpen, latestBids } from "../../cards/auction/auction";
import { AskedChoice, AskedMoment, AskedOnly, AskedWords } from "../../parts/filters/Asked";
import { CsvLink } from "../../parts/filters/CsvLink";
import { ListKeptNote } from "../../parts/kept/KeptNote";
import { Pages } from "../../parts/pages/Pages";
import { PrintButton } from "../../parts/paper/PrintButton";
import { countOf, sortBy, usePaged } from "../../parts/pages/paged";
import { ShowLink } from "../../parts/ShowLink";
import { names, placeOf, placesOf, plant, taskName } from "../../state";
import { addressOf, asked, storyOf } from "../../views";
import { queryOf, STATES, tableOf } from "./filter";
import { Result } from "./Result";

/** What is known of a task: by the stream as long as it has it, and by history. */
type Shown = Omit<TaskRecord, "round" | "deadline_at_s" | "contracted_at_s"> & { readonly live: TaskView | undefined };

const HEADS = ["task", "what", "way", "order", "state", "primary", "secondary", "opened", "promise", "result"] as const;
const SORTED = ["", "", "", "", "", "", "", "opened", "promised", "late"] as const;

/** The one that was announced last: the list is read anew when there is another. */
const newest = computed(() => [...(world.value?.tasks.keys() ?? [])].at(-1) ?? "");

/** The view, once it has its words. */
export async function load(): Promise<typeof TasksList> {
  await speakAlso(tables);
  return TasksList;
}

/** Every task that is kept, with its promise and what became of it. */
export function TasksList() {
  const { failed, page, printing } = usePaged(async (said, place) => await fetchTasks({ ...queryOf(said), ...place }), newest);
  const tasks = useComputed(() => (page.value?.items ?? []).map((record) => shownOf(record, world.value?.tasks.get(record.id)))).value;
  return (
    <Table
      title={t("tasks.title")}
      heads={HEADS.map((head) => t(`tasks.${head}`))}
      busy={page.value === null && failed.value === null}
      empty={emptyText(page.value === null, failed.value)}
      {...countOf(page.value)}
      sorting={{
        column: SORTED.findIndex((name) => name !== "" && name === asked.value.sort),
        descending: asked.value.down !== "no",
        by: (column) => { sortBy(SORTED[column] ?? "", true); },
        can: (column) => SORTED[column] !== "",
      }}
      note={<ListKeptNote kind="tasks" />}
      aside={<><a class="button" href="#transports">{t("tasks.called")}</a><Filters /><PrintButton of={printing} /></>}
      below={<Pages next={page.value?.next_cursor ?? null} />}
    >
      {tasks.map((task) => (
        <Row key={task.id} task={task} />
      ))}
    </Table>
  );
}

function emptyText(isLoading: boolean, failed: string | null): string {
  if (failed !== null) return t("list.failed", { reason: failed });
  if (isLoading) return t("view.loading");
  return t(Object.values(asked.value).some((said) => said !== "") ? "filter.none" : "tasks.none");
}

function Filters() {
  const states = STATES.map((id) => ({ id, name: word("state", id) }));
  const kinds = (["transport", "production"] as const).map((id) => ({ id, name: t(`tasks.kind.${id}`) }));
  const items = [...(plant.value?.materials ?? []), ...(plant.value?.products ?? [])];
  return (
    <>
      <AskedWords />
      <AskedChoice name="state" label={t("tasks.state")} options={states} />
      <AskedChoice name="kind" label={t("tasks.kind")} options={kinds} />
      <AskedChoice name="item" label={t("tasks.what")} options={items} />
      <AskedMoment name="since" label={t("list.since")} />
      <AskedMoment name="until" label={t("list.until")} />
      <AskedOnly name="late" label={t("orders.late")} />
      <CsvLink href={tableOf(asked.value)} />
    </>
  );
}

function shownOf(record: TaskRecord, live: TaskView | undefined): Shown {
  if (!live) return { ...record, live };
  const { closed_at_s, epoch, promised_at_s, state } = live;
  return {
    ...record, live, epoch, state, closed_at_s, promised_at_s,
    source: live.source || record.source, carrier: live.primary, standby: live.secondary,
  };
}

function Row({ task }: { task: Shown }) {
  const { live, order } = task;
  const source = placesOf(task.source);
  const opened = live && isOpen(live);
  const name = taskName(task.id, order, task.reference ?? order);
  const story = storyOf(task);
  const what = t("auction.what", { quantity: format.count(task.quantity), item: names.value(task.item) });
  return (
    <tr>
      <th scope="row">
        {live ? <ShowLink chosen={{ kind: "task", id: task.id }} name={name} label={t("tasks.open", { id: name })} /> : name}
      </th>
      <td>{story === "" ? what : <a class="link" href={story}>{what}</a>}</td>
      <td>{task.destination && t("auction.way", { source, destination: placeOf(task.destination) })}</td>
      <td>{order && <a class="link" href={addressOf(order)}>{task.reference ?? order}</a>}</td>
      <td>
        {live?.phase && opened ? word("phase", live.phase) : word("state", task.state)}
        {live?.trouble != null && <small class="line tone-warn">{causeText(live.trouble)}</small>}
      </td>
      <td>
        {task.carrier}
        {live && <Before task={live} />}
      </td>
      <td>{task.standby}</td>
      <td class="num">
        {format.when(task.opened_at_s, nowS.value)}
        {live && live.bids.length > 0 && <small class="line muted">{t("tasks.bidsOf", { n: format.count(latestBids(live.bids).length) })}</small>}
      </td>
      <td class="num">{task.promised_at_s !== null && format.when(task.promised_at_s, nowS.value)}</td>
      <td>
        <Result task={task} />
      </td>
    </tr>
  );
}

/** Who carried it before, in order. */
function Before({ task }: { task: TaskView }) {
  const before = task.carriers.slice(0, -1).flatMap(({ carrier }) => (carrier === "" ? [] : [carrier]));
  if (before.length === 0) return null;
  return <small class="line">{t("tasks.after", { before: format.list(before) })}</small>;
}
