import { signal } from "@preact/signals";
import { changeSchedule, fetchSchedules, removeSchedule, type Schedule } from "../../../api/schedules";
import { Table } from "../../../parts/Table";
import { Tag } from "../../../parts/Tag";
import { language, speakAlso } from "../../../text/speech";
import { format, t, tables } from "../../../text/views/recurring";
import { CsvLink } from "../../parts/filters/CsvLink";
import { RefusedSince } from "../../parts/RefusedSince";
import { Sure } from "../../parts/Sure";
import { problemText } from "../../problem-text";
import { useRefreshed } from "../../refreshed";
import { names, orderName } from "../../state";
import { addressOf, addressOfTransport } from "../../views";
import { calendarText } from "./calendar-text";
import { coming, daysOff, shown } from "./draft";
import { begin, openings } from "./form";
import "./recurring.css";
import { FORM, RecurringForm } from "./RecurringForm";
import { regionName } from "./regions";

const EVERY_MS = 10_000;

/** Between a moment and what can be done with it; where the line ends here, nothing is left of it. */
const SPACE = "\u2002";

const HEADS = ["name", "what", "calendar", "next", "last", "actions"] as const;

/** Which one somebody is asked about before it is removed; empty for none. */
const asked = signal("");
const failed = signal("");

/** The view, once it has its words. */
export async function load(): Promise<typeof Recurring> {
  await speakAlso(tables);
  return Recurring;
}

/** What is brought or ordered again and again: by which calendar, when next, and what came of it last. */
export function Recurring() {
  const { again, answer, failed: unread } = useRefreshed(fetchSchedules, EVERY_MS);
  const schedules = answer.value ?? [];
  const act = async (what: Promise<unknown>): Promise<void> => {
    failed.value = "";
    try {
      await what;
    } catch (error) {
      failed.value = t("recurring.failed", { reason: problemText(error) });
    }
    asked.value = "";
    again();
  };
  return (
    <Table
      title={t("recurring.title")}
      heads={HEADS.map((head) => t(`recurring.${head}`))}
      hint={t("recurring.hint")}
      empty={unread.value === null ? t(answer.value ? "recurring.none" : "view.loading") : t("list.failed", { reason: unread.value })}
      busy={answer.value === null && unread.value === null}
      aside={
        <>
          <CsvLink href="/api/schedules?format=csv" />
          <button type="button" class="button primary" popovertarget={FORM} onClick={() => { begin(null); }}>
            {t("recurring.add")}
          </button>
        </>
      }
      below={
        <>
          {failed.value !== "" && (
            <p class="complaint" role="alert">
              {failed.value}
            </p>
          )}
          <RefusedSince of={openings} form={FORM} />
          <RecurringForm onKept={again} />
        </>
      }
    >
      {schedules.map((schedule) => (
        <Row key={schedule.id} schedule={schedule} act={act} />
      ))}
    </Table>
  );
}

function Row({ act, schedule }: { schedule: Schedule; act: (what: Promise<unknown>) => Promise<void> }) {
  const { calendar, holidays, holidays_of, missed, name, next_runs, owner_gone, paused, skipped, time_zone } = schedule;
  const at = (moment: string): string => shown(moment, time_zone, language.value);
  const [next, ...later] = next_runs;
  const off = daysOff(holidays, new Date().toISOString().slice(0, 10), language.value);
  const leaveOut = (moments: readonly string[]): void => void act(changeSchedule(schedule, { skipped: [...moments] }));
  return (
    <tr>
      <th scope="row">
        <button type="button" class="link" popovertarget={FORM} title={t("recurring.change", { name })} onClick={() => { begin(schedule); }}>
          {name}
        </button>
      </th>
      <td>
        <What schedule={schedule} />
      </td>
      <td>
        {calendarText(calendar, language.value) ?? <code>{calendar}</code>}
        <small class="line muted">{time_zone}</small>
        {off.length > 0 && <small class="line muted">{t("recurring.notOn", { days: off.join(", ") })}</small>}
        {holidays_of !== "" && <small class="line muted">{t("recurring.notOnHolidaysOf", { region: regionName(holidays_of, language.value) })}</small>}
        {missed === "catch_up" && <small class="line muted">{t("recurring.madeUp")}</small>}
      </td>
      <td>
        {paused && <Tag tone="warn">{t("recurring.paused")}</Tag>}
        {owner_gone && <small class="line complaint">{t("recurring.ownerGone")}</small>}
        {!paused && (next === undefined ? "–" : at(next))}
        {SPACE}
        {next !== undefined && (
          <button type="button" class="link" aria-label={t("recurring.omitOf", { at: at(next), name })} onClick={() => { leaveOut([...skipped, next]); }}>
            {t("recurring.omit")}
          </button>
        )}
        <small class="line muted">{later.map(at).join(" · ")}</small>
        {coming(skipped, Date.now()).map((moment) => (
          <small class="line muted" key={moment}>
            {t("recurring.omitted", { at: at(moment) })}
            {SPACE}
            <button type="button" class="link" aria-label={t("recurring.undoOf", { at: at(moment), name })} onClick={() => { leaveOut(skipped.filter((each) => each !== moment)); }}>
              {t("recurring.undo")}
            </button>
          </small>
        ))}
      </td>
      <td>
        <Last schedule={schedule} />
      </td>
      <td class="recurring-actions">
        {asked.value === schedule.id ? (
          <Sure
            asked={t("recurring.sure", { name })}
            no={t("recurring.keep")}
            yes={t("recurring.remove")}
            busy={false}
            onNo={() => { asked.value = ""; }}
            onYes={() => void act(removeSchedule(schedule))}
          />
        ) : (
          <>
            <button type="button" class="button small" aria-label={t(paused ? "recurring.goOnWith" : "recurring.pauseOf", { name })} onClick={() => void act(changeSchedule(schedule, { paused: !paused }))}>
              {t(paused ? "recurring.goOn" : "recurring.pause")}
            </button>
            <button type="button" class="button small" aria-label={t("recurring.removeOf", { name })} onClick={() => { asked.value = schedule.id; }}>
              {t("recurring.remove")}
            </button>
          </>
        )}
      </td>
    </tr>
  );
}

function What({ schedule: { order, transport } }: { schedule: Schedule }) {
  if (order) {
    const { customer, due_after_s, items, reference } = order;
    const parts = [t("recurring.orderOf", { customer }), reference, due_after_s !== null && t("recurring.dueAfter", { hours: format.number(due_after_s / 3600, 1) })];
    return (
      <>
        {items.map(({ product, quantity }) => `${format.count(quantity)} ${names.value(product)}`).join(", ")}
        <small class="line muted">{parts.filter(Boolean).join(" · ")}</small>
      </>
    );
  }
  if (!transport) return null;
  const way = t("recurring.way", { from: transport.from ?? t("recurring.nearest"), to: transport.to ?? t("recurring.nearest") });
  return (
    <>
      {format.count(transport.quantity ?? 1)} {transport.thing ?? names.value(transport.item ?? "")}
      <small class="line muted">{[way, transport.vehicle, transport.ability].filter(Boolean).join(" · ")}</small>
    </>
  );
}

function Last({ schedule: { last, missed_at, time_zone } }: { schedule: Schedule }) {
  const at = (moment: string): string => shown(moment, time_zone, language.value);
  return (
    <>
      {last === null ? "–" : at(last.planned_at)}
      {last?.made_up_at != null && <small class="line muted">{t("recurring.madeUpAt", { at: at(last.made_up_at) })}</small>}
      {last?.transport != null && (
        <small class="line">
          <a class="link" href={addressOfTransport(last.transport)}>{last.transport}</a>
        </small>
      )}
      {last?.order != null && (
        <small class="line">
          <a class="link" href={addressOf(last.order)}>{orderName(last.order)}</a>
        </small>
      )}
      {last?.refused != null && <small class="line complaint">{t("recurring.refused", { reason: last.refused })}</small>}
      {missed_at !== null && <small class="line muted">{t("recurring.leftOut", { at: at(missed_at) })}</small>}
    </>
  );
}
