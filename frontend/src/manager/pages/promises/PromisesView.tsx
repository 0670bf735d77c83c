import { signal, useComputed } from "@preact/signals";
import { fetchPromises } from "../../../api/client";
import type { PromiseLedger, PromiseLine } from "../../../api/types";
import { Meter } from "../../../parts/Meter";
import { Table } from "../../../parts/Table";
import { world } from "../../../stream/stream";
import { speakAlso } from "../../../text/speech";
import { format, t, tables } from "../../../text/views/records";
import { type HeldKey, heldKey } from "../../parts/rows/held";
import { useRefreshed } from "../../refreshed";
import { ShowLink } from "../../parts/ShowLink";
import { AT_FIRST, COLUMNS, next, type Order, sorted } from "./ledger";

/** A person reads no faster, and every look is a question to the database. */
const AGAIN_MS = 5000;
/** What would be shown as no time at all. */
const PUNCTUAL_S = 0.05;
/** Below this share a vehicle's promises are worth a look. */
const GOOD_FRAC = 0.9;

const order = signal<Order>(AT_FIRST);

/** The view, once it has its words. */
export async function load(): Promise<typeof PromisesView> {
  await speakAlso(tables);
  return PromisesView;
}

/** The promise ledger: promised against real, per vehicle. */
export function PromisesView() {
  const { answer: ledger, failed } = useRefreshed(fetchPromises, AGAIN_MS);
  const lines = useComputed(() => (ledger.value ? sorted(ledger.value.items, order.value) : [])).value;
  const rows = lines.map((line) => <Row key={line.atv} line={line} within={ledger.value?.on_time_within_s ?? 0} />);
  const fleet = ledger.value?.fleet;
  const within = format.duration(ledger.value?.on_time_within_s ?? 0);
  return (
    <Table
      title={t("promises.title")}
      heads={COLUMNS.map((column) => t(`promises.${column}`))}
      explained={COLUMNS.map((column) => (column === "median" || column === "p95" ? t(`promises.${column}.says`) : ""))}
      {...(ledger.value ? { hint: t("promises.hint", { within }) } : {})}
      empty={emptyText(ledger.value, failed.value)}
      busy={ledger.value === null && failed.value === null}
      count={lines.length}
      aside={<Aside failed={failed.value} />}
      sorting={{
        column: COLUMNS.indexOf(order.value.column),
        descending: order.value.descending,
        by: (column) => {
          order.value = next(order.value, COLUMNS[column] ?? "vehicle");
        },
      }}
    >
      {fleet && rows.length > 0 ? [<Row key="" line={fleet} within={ledger.value?.on_time_within_s ?? 0} />, ...rows] : rows}
    </Table>
  );
}

function emptyText(ledger: PromiseLedger | null, failed: string | null): string {
  if (ledger) return t("promises.none");
  return failed === null ? t("promises.loading") : t("promises.failed", { reason: failed });
}

function Aside({ failed }: { failed: string | null }) {
  return (
    <>
      {failed !== null && (
        <span class="tone-warn" role="status">
          {t("promises.failed", { reason: failed })}
        </span>
      )}
      <a class="button" href="/api/promises?format=csv" download title={t("promises.csvTitle")}>
        {t("promises.csv")}
      </a>
    </>
  );
}

function Row({ line, within }: { line: PromiseLine; within: number }) {
  const { atv, delivered, last_at_s: lastAtS, lost, on_time_frac: frac } = line;
  const fleet = atv === "";
  const known = world.value?.atvs.has(atv) ?? false;
  return (
    <tr class={fleet ? "sum" : ""}>
      <th scope="row">
        {fleet ? t("promises.fleet") : known ? <ShowLink chosen={{ kind: "atv", id: atv }} label={t("fleet.show", { id: atv })} /> : atv}
      </th>
      <td class="num">{format.count(delivered)}</td>
      <td>{frac !== null && <OnTime frac={frac} />}</td>
      <Late lateS={line.median_s} within={within} />
      <Late lateS={line.p95_s} within={within} />
      <Late lateS={line.worst_s} within={within} task={line.worst_task} held={heldKey(line.worst_held, line.worst_held_by)} by={line.worst_held_by} />
      <td class={`num ${lost > 0 ? "" : "faint"}`}>{format.count(lost)}</td>
      <td class="num muted">{lastAtS !== null && format.clock(lastAtS)}</td>
    </tr>
  );
}

function OnTime({ frac }: { frac: number }) {
  const percent = format.percent(frac, 1);
  const good = frac >= GOOD_FRAC;
  return (
    <span class="share-on-time">
      <Meter frac={frac} label={percent} tone={good ? "normal" : "warn"} />
      <span class={`num ${good ? "" : "tone-warn"}`}>{percent}</span>
    </span>
  );
}

interface LateProps {
  lateS: number | null;
  task?: string;
  within: number;
  held?: HeldKey | null;
  by?: string;
}

function Late({ by = "", held = null, lateS, task = "", within }: LateProps) {
  if (lateS === null) return <td />;
  return (
    <td class={`num ${lateS > within ? "tone-warn" : ""}`}>
      {lateText(lateS)}
      {task !== "" && <small class="line">{t("promises.worstOf", { task })}{held !== null && `: ${t(`heldUp.${held}`, { by })}`}</small>}
    </td>
  );
}

function lateText(lateS: number): string {
  if (Math.abs(lateS) < PUNCTUAL_S) return t("promises.punctual");
  const by = format.price(Math.abs(lateS));
  return t(lateS > 0 ? "promises.late" : "promises.early", { by });
}
