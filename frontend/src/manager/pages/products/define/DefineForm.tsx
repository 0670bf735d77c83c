import type { ComponentProps } from "preact";
import { inFactoryTime } from "../../../../text/plant-time";
import { format, t } from "../../../../text/views/products";
import * as parts from "../../../parts/Field";
import { Outcome } from "../../../parts/Outcome";
import { Sheet } from "../../../parts/Sheet";
import { plant } from "../../../state";
import { type Amount, NO_AMOUNT, NO_PAPER, sha256Of } from "./draft";
import { complaints, edit, outcome, send, sending, written } from "./form";

/** What the button opens. */
export const FORM = "product-form";

/** Defines a product, or another revision of one: refusals stand at their fields. */
export function DefineForm({ onDefined }: { onDefined: () => void }) {
  const { ability, etag, id, lot, name } = written.value;
  const file = plant.value;
  const abilities = [...new Set(file?.vehicle_types.flatMap((type) => type.abilities) ?? [])];
  return (
    <Sheet id={FORM} title={t(etag === "" ? "products.defineTitle" : "products.changeTitle")}>
      <form
        class="product-form"
        noValidate
        onSubmit={(event) => {
          event.preventDefault();
          void send().then((defined) => {
            if (defined) onDefined();
          });
        }}
      >
        <div class="form">
          <Field part="id" label={t("products.id")}>
            {(attributes) => (
              <input {...attributes} autoComplete="off" maxLength={32} readOnly={etag !== ""} value={id} onInput={(event) => { edit({ id: event.currentTarget.value }); }} />
            )}
          </Field>
          <Field part="name" label={t("products.name")}>
            {(attributes) => <input {...attributes} autoComplete="off" maxLength={80} value={name} onInput={(event) => { edit({ name: event.currentTarget.value }); }} />}
          </Field>
          <Field part="lot" label={t("products.lotHint")}>
            {(attributes) => <input {...attributes} inputMode="numeric" autoComplete="off" value={lot} onInput={(event) => { edit({ lot: event.currentTarget.value }); }} />}
          </Field>
          <Field part="ability" label={t("products.ability")}>
            {(attributes) => (
              <select {...attributes} value={ability} onChange={(event) => { edit({ ability: event.currentTarget.value }); }}>
                {abilities.map((each) => (
                  <option key={each}>{each}</option>
                ))}
              </select>
            )}
          </Field>
        </div>
        <Amounts part="bill" title={t("products.bill")} what={t("products.material")} amount={t("products.amount")} add={t("products.addMaterial")} options={file?.materials ?? []} />
        <Amounts part="machines" title={inFactoryTime(t("products.machinesFor"))} what={t("products.machine")} amount={t("products.seconds")} add={t("products.addMachine")} options={file?.machines ?? []} />
        <Documents />
        <p class="form-actions">
          <Outcome of={outcome.value} />
          <button type="submit" class="button primary" disabled={sending.value}>
            {t("products.save")}
          </button>
        </p>
      </form>
    </Sheet>
  );
}

type PartProps = Pick<ComponentProps<typeof parts.Field>, "children"> & { part: string; label: string };

function Field({ children, label, part }: PartProps) {
  return (
    <parts.Field id={`product-${part}`} label={label} complaint={complaints.value[part]}>
      {children}
    </parts.Field>
  );
}

function Complaint({ part }: { part: string }) {
  return <parts.Complaint id={`product-${part}`} complaint={complaints.value[part]} />;
}

interface AmountsProps {
  part: "bill" | "machines";
  title: string;
  what: string;
  amount: string;
  add: string;
  options: readonly { id: string; name: string }[];
}

/** Rows of what and how much. */
function Amounts({ add, amount, options, part, title, what }: AmountsProps) {
  const rows = written.value[part];
  const change = (index: number, by: Partial<Amount>) => {
    edit({ [part]: rows.map((row, i) => (i === index ? { ...row, ...by } : row)) });
  };
  return (
    <fieldset>
      <legend>{title}</legend>
      {rows.map((row, i) => (
        <div key={i} class="product-row">
          <select
            aria-label={t("products.rowOf", { what, row: i + 1 })}
            aria-invalid={complaints.value[`${part}.${i}`] !== undefined}
            aria-describedby={`product-${part}.${i}-wrong`}
            value={row.what}
            onChange={(event) => { change(i, { what: event.currentTarget.value }); }}
          >
            <option value="">{what}</option>
            {options.map(({ id, name }) => (
              <option key={id} value={id}>
                {name === id ? id : `${id} · ${name}`}
              </option>
            ))}
          </select>
          <input
            aria-label={t("products.rowOf", { what: amount, row: i + 1 })}
            aria-describedby={`product-${part}.${i}-wrong`}
            inputMode="decimal"
            autoComplete="off"
            placeholder={amount}
            value={row.amount}
            onInput={(event) => { change(i, { amount: event.currentTarget.value }); }}
          />
          <Remove row={i} onClick={() => { edit({ [part]: rows.filter((_, j) => j !== i) }); }} />
          <Complaint part={`${part}.${i}`} />
        </div>
      ))}
      <Complaint part={part} />
      <button type="button" class="button small" onClick={() => { edit({ [part]: [...rows, NO_AMOUNT] }); }}>
        {add}
      </button>
    </fieldset>
  );
}

const PAPER = ["name", "address", "media_type", "sha256"] as const;

/** Documents by address and checksum; the checksum of a file at hand is counted here, and the file stays here. */
function Documents() {
  const papers = written.value.documents;
  const change = (index: number, by: Partial<(typeof papers)[number]>) => {
    edit({ documents: papers.map((paper, i) => (i === index ? { ...paper, ...by } : paper)) });
  };
  return (
    <fieldset>
      <legend>{t("products.documents")}</legend>
      <p class="muted">{t("products.documentsHint")}</p>
      {papers.map((paper, i) => (
        <div key={i} class="product-row product-paper">
          {PAPER.map((field) => (
            <input
              key={field}
              class={`paper-${field}`}
              aria-label={t("products.rowOf", { what: t(`products.paper.${field}`), row: i + 1 })}
              aria-describedby={`product-documents.${i}-wrong`}
              aria-invalid={complaints.value[`documents.${i}`] !== undefined}
              autoComplete="off"
              spellcheck={false}
              placeholder={t(`products.paper.${field}`)}
              value={paper[field]}
              onInput={(event) => { change(i, { [field]: event.currentTarget.value }); }}
            />
          ))}
          {/* Browsers count only on pages that nobody can have changed on the way. */}
          {"subtle" in crypto && (
            <label class="button small">
              {t("products.count")}
              <input
                type="file"
                class="unseen"
                onChange={(event) => {
                  const chosen = event.currentTarget.files?.[0];
                  if (chosen) void sha256Of(chosen).then((sha256) => { change(i, { sha256, media_type: chosen.type || paper.media_type, name: paper.name || chosen.name }); });
                }}
              />
            </label>
          )}
          <Remove row={i} onClick={() => { edit({ documents: papers.filter((_, j) => j !== i) }); }} />
          <Complaint part={`documents.${i}`} />
        </div>
      ))}
      <Complaint part="documents" />
      <button type="button" class="button small" onClick={() => { edit({ documents: [...papers, NO_PAPER] }); }}>
        {t("products.addDocument")}
      </button>
    </fieldset>
  );
}

function Remove({ onClick, row }: { row: number; onClick: () => void }) {
  return (
    <button type="button" class="button small" aria-label={t("products.removeRow", { row: format.count(row + 1) })} onClick={onClick}>
      {t("products.remove")}
    </button>
  );
}
