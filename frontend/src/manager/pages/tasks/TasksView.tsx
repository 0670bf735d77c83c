import { computed, signal, useComputed } from "@preact/signals";
import type { TaskView } from "../../../api/types";
import { Table } from "../../../parts/Table";
import { nowS, world } from "../../../stream/stream";
import { causeText } from "../../../text/failure";
import { format, t, word } from "../../../text/manager";
import { isOpen, latestBids } from "../../cards/auction/auction";
import { PUNCTUAL_S } from "../../cards/auction/times";
import { ShowLink } from "../../parts/ShowLink";
import { Choice } from "../../parts/filters/Choice";
import { CsvLink } from "../../parts/filters/CsvLink";
import { Only } from "../../parts/filters/Only";
import { Search } from "../../parts/filters/Search";
import { names, plant } from "../../state";
import { isWanted, STATES, type Wanted } from "./filter";

const words = signal("");
const state = signal("");
const item = signal("");
const late = signal(false);
const wanted = computed<Wanted>(() => ({ words: words.value, state: state.value, item: item.value, late: late.value }));

/** Every task of the stream with its promise and what became of it. */
export function TasksView() {
  const tasks = useComputed(() => inOrder(world.value?.tasks.values() ?? [])).value;
  const shown = tasks.filter((task) => isWanted(task, wanted.value, nowS.value, names.value));
  const heads = ["task", "what", "way", "state", "primary", "secondary", "bids", "promise", "result"] as const;
  return (
    <Table
      title={t("tasks.title")}
      heads={heads.map((head) => t(`tasks.${head}`))}
      empty={t(tasks.length === 0 ? "tasks.none" : "filter.none")}
      aside={<Filters />}
    >
      {shown.map((task) => (
        <Row key={task.id} task={task} />
      ))}
    </Table>
  );
}

function Filters() {
  const states = STATES.map((id) => ({ id, name: word("state", id) }));
  const items = [...(plant.value?.materials ?? []), ...(plant.value?.products ?? [])];
  return (
    <>
      <Search words={words} />
      <Choice label={t("tasks.state")} any={t("filter.any")} value={state.value} options={states} onChosen={(id) => (state.value = id)} />
      <Choice label={t("tasks.what")} any={t("filter.any")} value={item.value} options={items} onChosen={(id) => (item.value = id)} />
      <Only label={t("orders.late")} wanted={late} />
      <CsvLink href="/api/tasks?format=csv" />
    </>
  );
}

function inOrder(tasks: Iterable<TaskView>): TaskView[] {
  return [...tasks].sort((a, b) => Number(isOpen(b)) - Number(isOpen(a)) || b.opened_at_s - a.opened_at_s);
}

function Row({ task }: { task: TaskView }) {
  const source = task.source || task.sources.join(" / ");
  return (
    <tr>
      <th scope="row">
        <ShowLink chosen={{ kind: "task", id: task.id }} label={t("tasks.open", { id: task.id })} />
      </th>
      <td>{t("auction.what", { quantity: format.count(task.quantity), item: names.value(task.item) })}</td>
      <td>{task.destination && t("auction.way", { source, destination: task.destination })}</td>
      <td>
        {task.phase && isOpen(task) ? word("phase", task.phase) : word("state", task.state)}
        {task.trouble !== null && <small class="line tone-warn">{causeText(task.trouble)}</small>}
      </td>
      <td>
        {task.primary}
        <Before task={task} />
      </td>
      <td>{task.secondary}</td>
      <td class="num">{format.count(latestBids(task.bids).length)}</td>
      <td class="num">{task.promised_at_s !== null && format.clock(task.promised_at_s)}</td>
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

function Result({ task }: { task: TaskView }) {
  if (task.state !== "delivered" || task.closed_at_s === null || task.promised_at_s === null) return null;
  const lateS = (task.closed_at_s - task.promised_at_s) * (world.value?.factory.speed ?? 1);
  if (Math.abs(lateS) < PUNCTUAL_S) return <span>{t("tasks.onTime")}</span>;
  const by = format.duration(Math.abs(lateS));
  return lateS > 0 ? <span class="tone-warn">{t("tasks.broken", { by })}</span> : <span>{t("tasks.kept", { by })}</span>;
}
