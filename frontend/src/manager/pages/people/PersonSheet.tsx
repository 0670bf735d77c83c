import { useSignal } from "@preact/signals";
import { useLayoutEffect, useRef } from "preact/hooks";
import type { Person, SecretKind } from "../../../api/people";
import { t, word } from "../../../text/views/people";
import { Field } from "../../parts/Field";
import { keepFocus } from "../../parts/keep-focus";
import { Once } from "../../parts/Once";
import { Outcome } from "../../parts/Outcome";
import { Sheet } from "../../parts/Sheet";
import { Sure } from "../../parts/Sure";
import { me } from "../../shell/session";
import { areaName, plant } from "../../state";
import { add, busy, chosen, complaints, edit, editSecret, give, kind, link, makeLink, move, outcome, secret, setMay, ticked, written } from "./state";

/** What the buttons open. */
export const PERSON = "person-sheet";

interface Props {
  /** Something was changed. */
  readonly onChanged: () => void;
}

/** Somebody new, or all that is done to somebody whom there is. */
export function PersonSheet({ onChanged }: Props) {
  const person = chosen.value;
  const sheet = useRef<HTMLDivElement>(null);
  const isOut = person?.disabled_at_s != null;
  const made = link.value;
  // What was used last may be gone: the form of who was added, the button that made a link.
  useLayoutEffect(() => {
    if (sheet.current?.checkVisibility()) keepFocus(sheet.current);
  }, [person?.id, isOut, made]);
  return (
    <Sheet id={PERSON} title={person === null ? t("people.add") : t("people.changeOf", { name: person.name })}>
      <div ref={sheet} class="people-sheet">
        {person === null ? <New onChanged={onChanged} /> : <Known key={person.id} person={person} onChanged={onChanged} />}
        <p>
          <Outcome of={outcome.value} />
        </p>
      </div>
    </Sheet>
  );
}

/** A form that does one thing, and tells when it was done. */
function useDone(onChanged: () => void) {
  return (act: () => Promise<boolean>) => (event?: Event) => {
    event?.preventDefault();
    void act().then((done) => {
      if (done) onChanged();
    });
  };
}

function New({ onChanged }: Props) {
  const done = useDone(onChanged);
  const { id, name, role } = written.value;
  return (
    <form noValidate onSubmit={done(add)}>
      <div class="form">
        <Field id="people-id" label={t("people.id")} complaint={complaints.value.id}>
          {(attributes) => <input {...attributes} autoComplete="off" spellcheck={false} value={id} onInput={(event) => { edit({ id: event.currentTarget.value }); }} />}
        </Field>
        <Field id="people-name" label={t("people.called")} complaint={complaints.value.name}>
          {(attributes) => <input {...attributes} autoComplete="off" value={name} onInput={(event) => { edit({ name: event.currentTarget.value }); }} />}
        </Field>
        <Field id="people-role" label={t("people.role")} complaint={complaints.value.role}>
          {(attributes) => (
            <select {...attributes} value={role} onChange={(event) => { edit({ role: event.currentTarget.value === "manager" ? "manager" : "operator" }); }}>
              <option value="operator">{word("person.role", "operator")}</option>
              <option value="manager">{word("person.role", "manager")}</option>
            </select>
          )}
        </Field>
      </div>
      {role === "operator" && <Areas />}
      <p class="people-actions">
        <button type="submit" class="button primary">
          {t("people.addDo")}
        </button>
      </p>
    </form>
  );
}

function Areas() {
  const { areas } = written.value;
  return (
    <fieldset aria-describedby="people-areas-wrong">
      <legend>{t("people.areas")}</legend>
      {(plant.value?.areas ?? []).map((each) => (
        <label key={each.id} class="people-tick">
          <input type="checkbox" checked={areas.includes(each.id)} onChange={(event) => { edit({ areas: ticked(areas, each.id, event.currentTarget.checked) }); }} />
          {areaName(each.id)}
        </label>
      ))}
      <span id="people-areas-wrong" class="complaint">
        {complaints.value.areas}
      </span>
    </fieldset>
  );
}

function Known({ onChanged, person }: Props & { person: Person }) {
  const done = useDone(onChanged);
  const isOut = person.disabled_at_s !== null;
  return (
    <>
      {!isOut && (
        <>
          <section>
            <h3>{t("people.link")}</h3>
            {link.value === "" ? (
              <p class="people-actions">
                <span class="muted">{t("people.linkHint")}</span>
                <button type="button" class="button small" onClick={done(() => makeLink(person))}>
                  {t("people.linkMake")}
                </button>
              </p>
            ) : (
              <Once value={link.value} label={t("people.link")} copy={t("people.copy")} copied={t("people.copied")} notCopied={t("people.notCopied")} hint={t("people.linkOnce")} />
            )}
          </section>
          <Secret person={person} onChanged={onChanged} />
          {person.role === "operator" && (
            <form noValidate onSubmit={done(() => move(person))}>
              <Areas />
              <p class="people-actions">
                <button type="submit" class="button small">
                  {t("people.move")}
                </button>
              </p>
            </form>
          )}
        </>
      )}
      <Out person={person} isOut={isOut} onChanged={onChanged} />
    </>
  );
}

const OF_OPERATOR: readonly SecretKind[] = ["pin", "badge"];

function Secret({ onChanged, person }: Props & { person: Person }) {
  const done = useDone(onChanged);
  const of = kind.value;
  return (
    <form noValidate onSubmit={done(() => give(person))}>
      <h3>{t("people.secrets")}</h3>
      <div class="form">
        {person.role === "operator" && (
          <Field id="people-kind" label={t("people.kind")} complaint={complaints.value.kind}>
            {(attributes) => (
              <select {...attributes} value={of} onChange={(event) => { kind.value = event.currentTarget.value === "badge" ? "badge" : "pin"; editSecret(""); }}>
                {OF_OPERATOR.map((each) => (
                  <option key={each} value={each}>
                    {word("people.secret", each)}
                  </option>
                ))}
              </select>
            )}
          </Field>
        )}
        <Field id="people-secret" label={word("people.secretNew", of)} complaint={complaints.value.secret}>
          {(attributes) => (
            <input
              {...attributes}
              type="password"
              autoComplete="new-password"
              inputMode={of === "pin" ? "numeric" : "text"}
              value={secret.value}
              onInput={(event) => { editSecret(event.currentTarget.value); }}
            />
          )}
        </Field>
      </div>
      <p class="people-actions">
        <span class="muted">{t("people.ends")}</span>
        <button type="submit" class="button small">
          {t("people.give")}
        </button>
      </p>
    </form>
  );
}

function Out({ isOut, onChanged, person }: Props & { person: Person; isOut: boolean }) {
  const done = useDone(onChanged);
  const asking = useSignal(false);
  if (me.value?.kind === "person" && me.value.id === person.id) return <p class="muted">{t("people.you")}</p>;
  return (
    <p class="people-actions">
      {isOut ? (
        <button type="button" class="button small" onClick={done(() => setMay(person, true))}>
          {t("people.enable")}
        </button>
      ) : asking.value ? (
        <Sure
          asked={t("people.disableSure", { name: person.name })}
          no={t("people.disableNot")}
          yes={t("people.disable")}
          busy={busy.value}
          onNo={() => { asking.value = false; }}
          onYes={() => { asking.value = false; done(() => setMay(person, false))(); }}
        />
      ) : (
        <button type="button" class="button small" onClick={() => { asking.value = true; }}>
          {t("people.disable")}
        </button>
      )}
    </p>
  );
}
