import type { JSX } from "preact";
import { t } from "../../../text/manager";
import type { Field as FieldName } from "./draft";
import { complaints } from "./form";

interface Attributes {
  id: string;
  "aria-invalid": boolean;
  "aria-describedby": string;
}

interface Props {
  field: FieldName;
  label: string;
  optional?: boolean;
  children: (attributes: Attributes) => JSX.Element;
}

/** A labelled field with room for what is wrong with it. */
export function Field({ field, label, optional = false, children }: Props) {
  const complaint = complaints.value[field];
  const id = `publish-${field}`;
  return (
    <div class={`field field-${field}`}>
      <label for={id}>
        {label}
        {optional && <span class="faint"> {t("publish.optional")}</span>}
      </label>
      {children({ id, "aria-invalid": complaint !== undefined, "aria-describedby": `${id}-wrong` })}
      <span id={`${id}-wrong`} class="complaint">
        {complaint}
      </span>
    </div>
  );
}
