import { language } from "../../../text/speech";
import { t } from "../../../text/views/recurring";
import { PrioritySelect } from "../../orders/PrioritySelect";
import { Outcome } from "../../parts/Outcome";
import { Sheet } from "../../parts/Sheet";
import { toWrong } from "../../parts/to-wrong";
import { plant } from "../../state";
import { dayName, shown } from "./draft";
import { Choice, Field, Text } from "./fields";
import { before, busy, edit, outcome, preview, runs, send, written } from "./form";
import { OrderLines } from "./OrderLines";
import { countries } from "./regions";
import { DAYS } from "./rhythm";

/** What the button opens. */
export const FORM = "recurring-form";

/** Plans work that recurs, or changes it: refusals stand at their fields. */
export function RecurringForm({ onKept }: { onKept: () => void }) {
  const { cron, kind, missed } = written.value;
  return (
    <Sheet id={FORM} title={before.value === null ? t("recurring.addTitle") : t("recurring.changeTitle")}>
      <form
        class="recurring-form"
        noValidate
        onSubmit={(event) => {
          event.preventDefault();
          const form = event.currentTarget;
          void send().then((kept) => {
            if (kept) onKept();
            else toWrong(form);
          });
        }}
      >
        <div class="form">
          <Text part="name" label={t("recurring.name")} />
          <Field part="kind" label={t("recurring.kind")}>
            {(attributes) => (
              <select {...attributes} value={kind} onChange={(event) => { edit({ kind: event.currentTarget.value === "order" ? "order" : "transport" }); }}>
                <option value="transport">{t("recurring.transport")}</option>
                <option value="order">{t("recurring.order")}</option>
              </select>
            )}
          </Field>
          {kind === "order" ? <OrderFields /> : <TransportFields />}
          <Priority />
        </div>
        {kind === "order" && <OrderLines />}
        <Days off={cron.trim() !== ""} />
        <div class="form">
          <Text part="cron" label={t("recurring.cron")} />
          <Text part="zone" label={t("recurring.zone")} list={TIME_ZONES} />
          <Text part="holidays" label={t("recurring.holidays")} />
          <Text part="holidaysOf" label={t("recurring.holidaysOf")} list={COUNTRIES} />
          <Field part="missed" label={t("recurring.missed")}>
            {(attributes) => (
              <select {...attributes} value={missed} onChange={(event) => { edit({ missed: event.currentTarget.value === "catch_up" ? "catch_up" : "skip" }); }}>
                <option value="skip">{t("recurring.skip")}</option>
                <option value="catch_up">{t("recurring.catchUp")}</option>
              </select>
            )}
          </Field>
        </div>
        <datalist id={TIME_ZONES}>
          {Intl.supportedValuesOf("timeZone").map((zone) => (
            <option key={zone} value={zone} />
          ))}
        </datalist>
        <datalist id={COUNTRIES}>
          {countries(language.value).map(({ code, name }) => (
            <option key={code} value={code}>
              {name}
            </option>
          ))}
        </datalist>
        <Runs />
        <p class="form-actions">
          <Outcome of={outcome.value} />
          <button
            type="button"
            class="button"
            disabled={busy.value}
            onClick={({ currentTarget: { form } }) => {
              void preview().then((seen) => {
                if (!seen && form) toWrong(form);
              });
            }}
          >
            {t("recurring.preview")}
          </button>
          <button type="submit" class="button primary" disabled={busy.value}>
            {t("recurring.save")}
          </button>
        </p>
      </form>
    </Sheet>
  );
}

const TIME_ZONES = "recurring-zones";
const COUNTRIES = "recurring-countries";

function TransportFields() {
  const { only, vehicle } = written.value;
  const file = plant.value;
  const abilities = [...new Set(file?.vehicle_types.flatMap((type) => type.abilities) ?? [])];
  const places = [...(file?.storages ?? []), ...(file?.machines ?? [])];
  return (
    <>
      <Choice part="item" label={t("recurring.item")} none={t("recurring.choose")} options={file?.materials ?? []} />
      <Text part="thing" label={t("recurring.thing")} />
      <Text part="quantity" label={t("recurring.quantity")} numeric />
      <Choice part="from" label={t("recurring.from")} none={t("recurring.nearest")} options={places} />
      <Choice part="to" label={t("recurring.to")} none={t("recurring.nearest")} options={places} />
      <Choice part="vehicle" label={t("recurring.vehicle")} none={t("recurring.any")} options={file?.fleet ?? []} />
      <Choice part="ability" label={t("recurring.ability")} none={t("recurring.noAbility")} options={abilities.map((id) => ({ id }))} />
      {vehicle !== "" && (
        <label class="recurring-day">
          <input type="checkbox" checked={only} onChange={(event) => { edit({ only: event.currentTarget.checked }); }} />
          {t("recurring.only")}
        </label>
      )}
    </>
  );
}

function OrderFields() {
  return (
    <>
      <Text part="customer" label={t("recurring.customer")} />
      <Text part="reference" label={t("recurring.reference")} />
      <Text part="dueH" label={t("recurring.dueH")} numeric />
    </>
  );
}

function Priority() {
  return (
    <Field part="priority" label={t("orders.priority")}>
      {(attributes) => <PrioritySelect {...attributes} value={written.value.priority} onChoose={(chosen) => { edit({ priority: chosen }); }} />}
    </Field>
  );
}

/** The simple way to say when: on which days, at what time. */
function Days({ off }: { off: boolean }) {
  const { days, time } = written.value;
  return (
    <fieldset disabled={off}>
      <legend>{t("recurring.when")}</legend>
      <div class="recurring-days">
        {DAYS.map((day) => (
          <label key={day} class="recurring-day">
            <input
              type="checkbox"
              checked={days.includes(day)}
              onChange={({ currentTarget: { checked } }) => { edit({ days: checked ? [...days, day] : days.filter((each) => each !== day) }); }}
            />
            {dayName(day, language.value)}
          </label>
        ))}
        <label class="recurring-time">
          {t("recurring.time")}
          <input type="time" required value={time} onInput={(event) => { edit({ time: event.currentTarget.value }); }} />
        </label>
      </div>
    </fieldset>
  );
}

function Runs() {
  if (runs.value === null) return null;
  const { moments, zone } = runs.value;
  return (
    <section aria-label={t("recurring.next")} class="recurring-runs">
      <h3>{t("recurring.nextIn", { zone })}</h3>
      <ol>
        {moments.map((moment) => (
          <li key={moment}>
            <time dateTime={moment}>{shown(moment, zone, language.value)}</time>
          </li>
        ))}
      </ol>
    </section>
  );
}
