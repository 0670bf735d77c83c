import { useLayoutEffect, useRef } from "preact/hooks";
import { t, word } from "../../../text/views/people";
import { Choice, Field } from "../../parts/Field";
import { keepFocus } from "../../parts/keep-focus";
import { Once } from "../../parts/Once";
import { Sheet } from "../../parts/Sheet";
import { me } from "../../shell/session";
import { plant } from "../../state";
import { addKey, complaints, editKey, isButton, key, outcome, ticked, token } from "./state";

/** What the button opens. */
export const KEY = "key-sheet";

/** Makes a key for another system, or for a call button; it is shown once. */
export function KeySheet({ onChanged }: { onChanged: () => void }) {
  const sheet = useRef<HTMLDivElement>(null);
  const made = token.value;
  // The form is gone once the key is there.
  useLayoutEffect(() => {
    if (sheet.current?.checkVisibility()) keepFocus(sheet.current);
  }, [made]);
  return (
    <Sheet id={KEY} title={t("people.keyAdd")}>
      <div ref={sheet} class="people-sheet">
        {token.value === "" ? (
          <Draft onChanged={onChanged} />
        ) : (
          <Once value={token.value} label={t("people.keyToken")} copy={t("people.copy")} copied={t("people.copied")} notCopied={t("people.notCopied")} hint={t("people.keyOnce")} />
        )}
        <p role="status" class="outcome outcome-bad">
          {outcome.value?.text}
        </p>
      </div>
    </Sheet>
  );
}

function Draft({ onChanged }: { onChanged: () => void }) {
  const { days, name, place, scopes } = key.value;
  const file = plant.value;
  return (
    <form
      noValidate
      onSubmit={(event) => {
        event.preventDefault();
        void addKey().then((done) => {
          if (done) onChanged();
        });
      }}
    >
      <div class="form">
        <Field id="key-name" label={t("people.keyName")} complaint={complaints.value.name}>
          {(attributes) => <input {...attributes} autoComplete="off" value={name} onInput={(event) => { editKey({ name: event.currentTarget.value }); }} />}
        </Field>
        <Field id="key-days" label={t("people.days")} complaint={complaints.value.days}>
          {(attributes) => <input {...attributes} autoComplete="off" inputMode="numeric" value={days} onInput={(event) => { editKey({ days: event.currentTarget.value }); }} />}
        </Field>
      </div>
      <fieldset aria-describedby="key-scopes-wrong">
        <legend>{t("people.scopes")}</legend>
        {[...(me.value?.scopes ?? [])].sort().map((each) => (
          <label key={each} class="people-tick">
            <input type="checkbox" checked={scopes.includes(each)} onChange={(event) => { editKey({ scopes: ticked(scopes, each, event.currentTarget.checked) }); }} />
            {word("audit.value", each)}
          </label>
        ))}
        <span id="key-scopes-wrong" class="complaint">
          {complaints.value.scopes}
        </span>
      </fieldset>
      {isButton(scopes) && (
        <Choice
          id="key-place"
          label={t("people.place")}
          complaint={complaints.value.place}
          none={t("people.everywhere")}
          value={place}
          options={[...(file?.machines ?? []), ...(file?.storages ?? [])]}
          onChosen={(value) => { editKey({ place: value }); }}
        />
      )}
      <p class="people-actions">
        <button type="submit" class="button primary">
          {t("people.keyMake")}
        </button>
      </p>
    </form>
  );
}
