import type { ComponentProps } from "preact";
import { fetchPriorities, type Priorities } from "../../../api/transports";
import { format, t, word } from "../../../text/views/transports";
import { PRIORITIES } from "../../orders/priority";
import { PrioritySelect } from "../../orders/PrioritySelect";
import * as parts from "../../parts/Field";
import { Outcome } from "../../parts/Outcome";
import { toWrong } from "../../parts/to-wrong";
import { Sheet } from "../../parts/Sheet";
import { useRefreshed } from "../../refreshed";
import { plant } from "../../state";
import { addressOfTransport } from "../../views";
import { busy, complaints, edit, LOADS_MOST, loadsText, outcome, send, splitBy, type Written, written } from "./call";

/** What the button opens. */
export const FORM = "call-form";

const AGEING = "call-ageing";

// Its figures change with the gateway's version only.
const PRIORITIES_EVERY_MS = 3_600_000;

/** What priorities mean, and how long what is low waits for others. */
export function ageingText({ passed_most_s: mostS, transports }: Priorities): string {
  const minutes = (spanS: number): string => format.count(spanS / 60);
  const within = PRIORITIES.map((each) => t("called.within", { priority: word("priority", each), minutes: minutes(transports[each] ?? 0) }));
  return t("called.ageing", { within: format.list(within), most: minutes(mostS) });
}

type TextPart = { [K in keyof Written]: Written[K] extends string ? K : never }[keyof Written];

/** Calls for one load: refusals stand at their fields. */
export function CallForm({ onCalled }: { onCalled: () => void }) {
  const { begin, due, only, priority, quantity, thing, vehicle } = written.value;
  const file = plant.value;
  const { answer: priorities } = useRefreshed(fetchPriorities, PRIORITIES_EVERY_MS);
  const places = [...(file?.storages ?? []), ...(file?.machines ?? [])];
  const abilities = [...new Set(file?.vehicle_types.flatMap((type) => type.abilities) ?? [])];
  const loads = splitBy.value === 0 ? 1 : Math.ceil(Number(quantity) / splitBy.value);
  return (
    <Sheet id={FORM} title={t("called.callTitle")}>
      <form
        class="call-form"
        noValidate
        onSubmit={(event) => {
          event.preventDefault();
          const form = event.currentTarget;
          void send().then((called) => {
            if (called) onCalled();
            else toWrong(form);
          });
        }}
      >
        <div class="form">
          <Choice part="item" label={t("called.item")} none={t("called.choose")} options={file?.materials ?? []} />
          <Field part="thing" label={t("called.orThing")}>
            {(attributes) => <input {...attributes} autoComplete="off" maxLength={100} placeholder={t("called.thingAs")} value={thing} onInput={(event) => { edit({ thing: event.currentTarget.value }); }} />}
          </Field>
          <Field part="quantity" label={t("called.quantity")}>
            {(attributes) => <input {...attributes} inputMode="numeric" autoComplete="off" value={quantity} onInput={(event) => { edit({ quantity: event.currentTarget.value }); }} />}
          </Field>
          <Choice part="from" label={t("called.source")} none={t("called.nearest")} options={places} />
          <Choice part="to" label={t("called.to")} none={t("called.nearest")} options={places} />
          <Field part="priority" label={t("orders.priority")}>
            {(attributes) => <PrioritySelect {...attributes} aria-describedby={`${attributes["aria-describedby"]} ${AGEING}`} value={priority} onChoose={(chosen) => { edit({ priority: chosen }); }} />}
          </Field>
          <Field part="due" label={t("called.dueAt")}>
            {(attributes) => <input {...attributes} type="datetime-local" value={due} onChange={(event) => { edit({ due: event.currentTarget.value }); }} />}
          </Field>
          <Field part="begin" label={t("called.notBefore")}>
            {(attributes) => <input {...attributes} type="datetime-local" value={begin} onChange={(event) => { edit({ begin: event.currentTarget.value }); }} />}
          </Field>
          <Choice part="vehicle" label={t("called.vehicle")} none={t("called.anyVehicle")} options={file?.fleet ?? []} />
          <Choice part="ability" label={t("called.ability")} none={t("called.noAbility")} options={abilities.map((id) => ({ id }))} />
          {vehicle !== "" && (
            <label class="only">
              <input type="checkbox" checked={only} onChange={(event) => { edit({ only: event.currentTarget.checked }); }} />
              {t("called.only")}
            </label>
          )}
        </div>
        <p id={AGEING} class="muted">
          {priorities.value && ageingText(priorities.value)}
        </p>
        {loads > LOADS_MOST && <p>{t("called.tooMany", { loads: format.count(loads), most: format.count(LOADS_MOST) })}</p>}
        {loads > 1 && loads <= LOADS_MOST && (
          <p>
            <button
              type="button"
              class="button"
              disabled={busy.value}
              onClick={() => {
                void send(splitBy.value).then((called) => {
                  if (called) onCalled();
                });
              }}
            >
              {t("called.split", { loads: loadsText(Number(quantity), splitBy.value) })}
            </button>
          </p>
        )}
        <p class="form-actions">
          <Outcome of={outcome.value}>
            {outcome.value?.called !== undefined && (
              <a class="link" href={addressOfTransport(outcome.value.called)}>{outcome.value.called}</a>
            )}
          </Outcome>
          <button type="submit" class="button primary" disabled={busy.value}>
            {t("called.send")}
          </button>
        </p>
      </form>
    </Sheet>
  );
}

type PartProps = Pick<ComponentProps<typeof parts.Field>, "children"> & { part: string; label: string };

function Field({ children, label, part }: PartProps) {
  return (
    <parts.Field id={`call-${part}`} label={label} complaint={complaints.value[part]}>
      {children}
    </parts.Field>
  );
}

type ChoiceProps = Pick<ComponentProps<typeof parts.Choice>, "none" | "options"> & { part: TextPart; label: string };

function Choice({ part, ...choice }: ChoiceProps) {
  return (
    <parts.Choice
      {...choice}
      id={`call-${part}`}
      complaint={complaints.value[part]}
      value={written.value[part]}
      onChosen={(value) => { edit({ [part]: value }); }}
    />
  );
}
