import type { ComponentProps } from "preact";
import { t } from "../../../text/manager";
import { Field as LabelledField } from "../../parts/Field";
import type { Field as FieldName } from "./draft";
import { complaints } from "./form";

interface Props extends Pick<ComponentProps<typeof LabelledField>, "children"> {
  field: FieldName;
  label: string;
  optional?: boolean;
}

/** A field of the form of orders. */
export function Field({ field, label, optional = false, children }: Props) {
  const marked = (
    <>
      {label}
      {optional && <span class="faint"> {t("publish.optional")}</span>}
    </>
  );
  return (
    <LabelledField id={`publish-${field}`} class={`field-${field}`} label={marked} complaint={complaints.value[field]}>
      {children}
    </LabelledField>
  );
}
