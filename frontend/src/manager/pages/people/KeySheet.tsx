import { useLayoutEffect, useRef } from "preact/hooks";
import { t, word } from "../../../text/views/people";
import { Field } from "../../parts/Field";
import { keepFocus } from "../../parts/keep-focus";
import { PrioritySelect } from "../../orders/PrioritySelect";
import { Once } from "../../parts/Once";
import { Outcome } from "../../parts/Outcome";
import { Sheet } from "../../parts/Sheet";
import { me } from "../../shell/session";
import { plant } from "../../state";
import { addKey, calls, complaints, editKey, key, outcome, page, ticked, token } from "./state";

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
          <>
            <Once value={token.value} label={t("people.keyToken")} copy={t("people.copy")} copied={t("people.copied")} notCopied={t("people.notCopied")} hint={t("people.keyOnce")} />
            {page.value !== "" && <Page token={token.value} url={page.value} />}
          </>
        )}
        <p>
          <Outcome of={outcome.value} />
        </p>
      </div>
    </Sheet>
  );
}

/** A call button's page, for phones: its address, the same as a QR code, and a sign with both. */
function Page({ token: shown, url }: { token: string; url: string }) {
  // Of this gateway: the address itself may be that of a proxy before it.
  const own = `/call/${shown}`;
  return (
    <section class="people-page" aria-labelledby="key-page">
      <h3 id="key-page">{t("people.page")}</h3>
      <Once value={url} label={t("people.pageAddress")} copy={t("people.copy")} copied={t("people.copied")} notCopied={t("people.notCopied")} hint={t("people.pageHint")}>
        <a class="button small" href={`${own}/sign`} target="_blank" rel="noreferrer">
          {t("people.pageSign")}
        </a>
      </Once>
      <img src={`${own}/code.svg`} alt={t("people.pageCode")} width={220} height={220} />
    </section>
  );
}

function Draft({ onChanged }: { onChanged: () => void }) {
  const { days, name, scopes } = key.value;
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
      {calls(scopes) && <Limits />}
      <p class="people-actions">
        <button type="submit" class="button primary">
          {t("people.keyMake")}
        </button>
      </p>
    </form>
  );
}

/** Which transports the key may call for. */
function Limits() {
  const { items, open, openEach, places, priority } = key.value;
  const file = plant.value;
  return (
    <>
      <p class="muted">{t("people.limitsHint")}</p>
      <Ticks id="key-places" label={t("people.places")} complaint={complaints.value.places} of={[...(file?.machines ?? []), ...(file?.storages ?? [])]} ticked={places} onTicked={(chosen) => { editKey({ places: chosen }); }} />
      <Ticks id="key-items" label={t("people.items")} complaint={complaints.value.items} of={file?.materials ?? []} ticked={items} onTicked={(chosen) => { editKey({ items: chosen }); }} />
      <div class="form">
        <Field id="key-open" label={t("people.open")} complaint={complaints.value.open_max}>
          {(attributes) => <input {...attributes} autoComplete="off" inputMode="numeric" placeholder="50" value={open} onInput={(event) => { editKey({ open: event.currentTarget.value }); }} />}
        </Field>
        <Field id="key-open-each" label={t("people.openEach")} complaint={complaints.value.open_each_max}>
          {(attributes) => <input {...attributes} autoComplete="off" inputMode="numeric" placeholder="20" value={openEach} onInput={(event) => { editKey({ openEach: event.currentTarget.value }); }} />}
        </Field>
        <Field id="key-priority" label={t("people.priority")} complaint={complaints.value.priority}>
          {(attributes) => <PrioritySelect {...attributes} value={priority} onChoose={(chosen) => { editKey({ priority: chosen }); }} />}
        </Field>
      </div>
    </>
  );
}

interface TicksProps {
  readonly id: string;
  readonly label: string;
  readonly complaint: string | undefined;
  readonly of: readonly { id: string; name?: string }[];
  readonly ticked: readonly string[];
  readonly onTicked: (chosen: string[]) => void;
}

/** Some things of the plant; none of them ticked stands for all. */
function Ticks({ complaint, id, label, of, onTicked, ticked: chosen }: TicksProps) {
  return (
    <fieldset class="people-many" aria-describedby={`${id}-wrong`}>
      <legend>{label}</legend>
      {of.map(({ id: each, name = each }) => (
        <label key={each} class="people-tick">
          <input type="checkbox" checked={chosen.includes(each)} onChange={(event) => { onTicked(ticked(chosen, each, event.currentTarget.checked)); }} />
          {name === each ? each : `${each} · ${name}`}
        </label>
      ))}
      <span id={`${id}-wrong`} class="complaint">
        {complaint}
      </span>
    </fieldset>
  );
}
