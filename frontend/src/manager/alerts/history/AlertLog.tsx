import { computed } from "@preact/signals";
import { whatText } from "../../../alerts/alert-text";
import { type AlertRecord, fetchAlerts } from "../../../api/client";
import { columnsOf } from "../../../parts/stacked";
import { Tag } from "../../../parts/Tag";
import { nowS, world } from "../../../stream/stream";
import { format, t } from "../../../text/views/alerts";
import { AskedChoice, AskedMoment, AskedWords } from "../../parts/filters/Asked";
import { CsvLink } from "../../parts/filters/CsvLink";
import { ListKeptNote } from "../../parts/kept/KeptNote";
import { Pages } from "../../parts/pages/Pages";
import { PrintButton } from "../../parts/paper/PrintButton";
import { countOf, usePaged } from "../../parts/pages/paged";
import { MomentLink } from "../../replay/MomentLink";
import { alerts } from "../../state";
import { addressOf, asked } from "../../views";
import { orderOf, subjectOf } from "../subject";
import { KINDS, LEVELS, queryOf, STATES, tableOf } from "./filter";

const HEADS = ["alerts.subject", "alerts.problem", "alertLog.from", "alertLog.to", "alertLog.words"] as const;

/** Another value whenever an alert has come, gone or been spoken of: the list is read anew. */
const newest = computed(() => alerts.value.map(({ acknowledged_at_s: atS, comment, id }) => `${id} ${atS ?? ""} ${comment}`).join("\n"));

/** All alerts that are kept, and what people said of them. */
export function AlertLog() {
  const { failed, page, printing } = usePaged(async (said, place) => await fetchAlerts({ ...queryOf(said), ...place }), newest);
  const records = page.value?.items ?? [];
  const { count, more } = countOf(page.value);
  return (
    <section class="card" aria-label={t("alertLog.title")} aria-busy={page.value === null && failed.value === null}>
      <header class="card-head">
        <h2>{t("alertLog.title")}</h2>
        <span class="count">{format.count(count)}{more && "+"}</span>
        <div class="table-aside"><Filters /><PrintButton of={printing} /></div>
      </header>
      <ListKeptNote kind="alerts" />
      {records.length === 0 ? (
        <p class="empty">{emptyText(page.value === null, failed.value)}</p>
      ) : (
        <div class="table-scroll" tabIndex={0} role="group" aria-label={t("alertLog.title")}>
          <table class="stacked" style={columnsOf(HEADS.map((head) => t(head)))}>
            <thead>
              <tr>{HEADS.map((head) => <th key={head} scope="col">{t(head)}</th>)}</tr>
            </thead>
            <tbody>{records.map((record) => <Row key={record.number} record={record} />)}</tbody>
          </table>
        </div>
      )}
      <Pages next={page.value?.next_cursor ?? null} />
    </section>
  );
}

function emptyText(isLoading: boolean, failed: string | null): string {
  if (failed !== null) return t("list.failed", { reason: failed });
  if (isLoading) return t("view.loading");
  return t(Object.values(asked.value).some((said) => said !== "") ? "filter.none" : "alertLog.none");
}

function Filters() {
  return (
    <>
      <AskedWords />
      <AskedChoice name="kind" label={t("alertLog.kind")} options={KINDS.map((id) => ({ id, name: t(`alertLog.is.${id}`) }))} />
      <AskedChoice name="level" label={t("alertLog.level")} options={LEVELS.map((id) => ({ id, name: t(`alerts.kind.${id}`) }))} />
      <AskedChoice name="state" label={t("alertLog.state")} options={STATES.map((id) => ({ id, name: t(`alertLog.state.${id}`) }))} />
      <AskedMoment name="since" label={t("list.since")} />
      <AskedMoment name="until" label={t("list.until")} />
      <CsvLink href={tableOf(asked.value)} />
    </>
  );
}

function Row({ record }: { record: AlertRecord }) {
  const subject = record.reference ?? subjectOf(record);
  const order = record.reference === null ? orderOf(record) : record.order;
  // As it was said last: how long ago something was is told as of then.
  const thenS = record.ended_at_s ?? nowS.value;
  return (
    <tr>
      <th scope="row">{order === "" ? <span class="name">{subject}</span> : <a class="link" href={addressOf(order)}>{subject}</a>}</th>
      <td>
        <Tag tone={record.level === "alarm" ? "alarm" : "warn"}>{t(`alerts.kind.${record.level}`)}</Tag>{" "}
        {whatText(record, thenS, world.value?.factory.speed ?? 1)}
      </td>
      <td class="num">
        {format.when(record.since_at_s, nowS.value)} <MomentLink atS={record.since_at_s} about={subject} />
      </td>
      <td class="num">{record.ended_at_s === null ? t("alertLog.lasts") : format.when(record.ended_at_s, nowS.value)}</td>
      <td>
        {record.words.map((word) => (
          <span key={word.at_s} class="line">
            {wordText(word, nowS.value)}
            {word.comment !== "" && <>: <q>{word.comment}</q></>}
          </span>
        ))}
      </td>
    </tr>
  );
}

function wordText({ at_s, by, said, until_at_s }: AlertRecord["words"][number], now: number): string {
  const told = { at: format.when(at_s, now), by };
  if (said === "taken" && until_at_s !== null) return t("alertLog.did.takenUntil", { ...told, until: format.when(until_at_s, now) });
  return t(`alertLog.did.${said}`, told);
}
