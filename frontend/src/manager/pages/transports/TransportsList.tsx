import { signal } from "@preact/signals";
import { callOff, fetchCalled, type TransportAnswer } from "../../../api/transports";
import { Table } from "../../../parts/Table";
import { nowS } from "../../../stream/stream";
import { speakAlso } from "../../../text/speech";
import { format, t, tables, word } from "../../../text/views/transports";
import { AskedChoice, AskedWords } from "../../parts/filters/Asked";
import { CsvLink } from "../../parts/filters/CsvLink";
import { Pages } from "../../parts/pages/Pages";
import { countOf, sortBy, usePaged } from "../../parts/pages/paged";
import { Sure } from "../../parts/Sure";
import { problemText } from "../../problem-text";
import { names, plant } from "../../state";
import { addressOfTransport, asked as address } from "../../views";
import "./call.css";
import { CallForm, FORM } from "./CallForm";
import { canCallOff, queryOf, STATES, tableOf } from "./filter";

const HEADS = ["what", "way", "state", "vehicle", "by", "at", "due", "actions"] as const;
const SORTED = ["", "", "", "", "", "called", "due", ""] as const;

/** Which one somebody is asked about before it is called off; empty for none. */
const asked = signal("");
const failed = signal("");

/** The view, once it has its words. */
export async function load(): Promise<typeof TransportsList> {
  await speakAlso(tables);
  return TransportsList;
}

/** What was called for: how far it is, who carries it, and why it waits. */
export function TransportsList() {
  const { again, failed: unread, page } = usePaged(async (said, place) => await fetchCalled({ ...queryOf(said), ...place }));
  const end = async (transport: string): Promise<void> => {
    failed.value = "";
    try {
      await callOff(transport);
    } catch (error) {
      failed.value = t("called.failed", { reason: problemText(error) });
    }
    asked.value = "";
    again();
  };
  return (
    <Table
      title={t("called.title")}
      heads={HEADS.map((head) => t(`called.${head}`))}
      hint={t("called.hint")}
      empty={emptyText(page.value === null, unread.value)}
      busy={page.value === null && unread.value === null}
      {...countOf(page.value)}
      sorting={{
        column: SORTED.findIndex((name) => name !== "" && name === (address.value.sort ?? "called")),
        descending: address.value.down !== "no",
        by: (column) => { sortBy(SORTED[column] ?? "", true); },
        can: (column) => SORTED[column] !== "",
      }}
      aside={
        <>
          <Filters />
          <button type="button" class="button primary" popovertarget={FORM}>
            {t("called.call")}
          </button>
        </>
      }
      below={
        <>
          <Pages next={page.value?.next_cursor ?? null} />
          {failed.value !== "" && (
            <p class="complaint" role="alert">
              {failed.value}
            </p>
          )}
          <CallForm onCalled={again} />
        </>
      }
    >
      {(page.value?.items ?? []).map((transport) => (
        <Row key={transport.id} transport={transport} end={end} />
      ))}
    </Table>
  );
}

function emptyText(isLoading: boolean, unread: string | null): string {
  if (unread !== null) return t("list.failed", { reason: unread });
  if (isLoading) return t("view.loading");
  return t(Object.values(address.value).some((said) => said !== "") ? "filter.none" : "called.none");
}

function Filters() {
  const states = [{ id: "open", name: t("called.open") }, ...STATES.map((id) => ({ id, name: word("called.is", id) }))];
  const places = [...(plant.value?.storages ?? []), ...(plant.value?.machines ?? [])].map(({ id }) => ({ id, name: id }));
  return (
    <>
      <AskedWords />
      <AskedChoice name="state" label={t("called.state")} options={states} />
      <AskedChoice name="place" label={t("called.place")} options={places} />
      <CsvLink href={tableOf(address.value)} />
    </>
  );
}

/** Why it waits; of one that is not to begin yet, when it does. */
export function waitText(wait: string, notBefore: string | null): string {
  return wait === "not_before" && notBefore !== null ? t("called.begins", { at: when(notBefore) }) : word("calling.wait", wait);
}

function when(moment: string): string {
  return format.when(Date.parse(moment) / 1000, nowS.value);
}

function Row({ end, transport }: { transport: TransportAnswer; end: (id: string) => Promise<void> }) {
  const { called_by, created_at, due_at, id, item, priority, quantity, thing, to } = transport;
  return (
    <tr>
      <th scope="row">
        {format.count(quantity)} {thing ?? names.value(item)}
        <small class="line">
          <a class="link" href={addressOfTransport(id)}>{id}</a>
        </small>
      </th>
      <td>{t("called.wayOf", { source: transport.from, to })}</td>
      <td>
        <State transport={transport} />
      </td>
      <td>
        <Carrier transport={transport} />
      </td>
      <td>{called_by}</td>
      <td class="num">{when(created_at)}</td>
      <td class="num">
        {when(due_at)}
        {priority !== "normal" && <small class="line muted">{word("priority", priority)}</small>}
      </td>
      <td>
        {canCallOff(transport) &&
          (asked.value === id ? (
            <Sure
              asked={t("called.sure", { id })}
              no={t("called.keep")}
              yes={t("called.off")}
              busy={false}
              onNo={() => { asked.value = ""; }}
              onYes={() => void end(id)}
            />
          ) : (
            <button type="button" class="button small" aria-label={t("called.offOf", { id })} onClick={() => { asked.value = id; }}>
              {t("called.off")}
            </button>
          ))}
      </td>
    </tr>
  );
}

/** How far it is, and why it waits. */
function State({ transport: { cancel_at, ended_at, expected_at, not_before, refused, status, wait } }: { transport: TransportAnswer }) {
  return (
    <>
      {cancel_at !== null && ended_at === null ? t("called.beingOff") : word("called.is", status)}
      {wait !== null && <small class={`line ${wait === "not_before" ? "muted" : "tone-warn"}`}>{waitText(wait, not_before)}</small>}
      {refused !== null && <small class="line tone-warn">{word("called.refused", refused)}</small>}
      {expected_at !== null && ended_at === null && <small class="line muted">{t("called.expected", { at: when(expected_at) })}</small>}
    </>
  );
}

/** Who carries it; who is wanted, and why that one does not. */
function Carrier({ transport: { ability, carrier, vehicle, vehicle_until, vehicle_waits } }: { transport: TransportAnswer }) {
  return (
    <>
      {carrier ?? vehicle ?? "–"}
      {vehicle !== null && vehicle_waits !== null && <small class="line tone-warn">{t("called.wantedIs", { vehicle, why: word("unwilling", vehicle_waits) })}</small>}
      {vehicle_until !== null && <small class="line muted">{t("called.until", { at: when(vehicle_until) })}</small>}
      {ability !== null && <small class="line muted">{t("called.asks", { ability })}</small>}
    </>
  );
}
