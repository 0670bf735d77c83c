/** The fields of the form of recurring work. */
import type { ComponentProps } from "preact";
import * as parts from "../../parts/Field";
import type { Written } from "./draft";
import { complaints, edit, written } from "./form";

type TextPart = { [K in keyof Written]: Written[K] extends string ? K : never }[keyof Written];

type PartProps = Pick<ComponentProps<typeof parts.Field>, "children"> & { part: string; label: string };

/** A field of the form. */
export function Field({ children, label, part }: PartProps) {
  return (
    <parts.Field id={`recurring-${part}`} label={label} complaint={complaints.value[part]}>
      {children}
    </parts.Field>
  );
}

/** What is wrong with a part of the form. */
export function Complaint({ part }: { part: string }) {
  return <parts.Complaint id={`recurring-${part}`} complaint={complaints.value[part]} />;
}

/** A line of text. */
export function Text({ label, list, numeric = false, part }: { part: TextPart; label: string; list?: string; numeric?: boolean }) {
  return (
    <Field part={part} label={label}>
      {(attributes) => (
        <input
          {...attributes}
          autoComplete="off"
          spellcheck={false}
          list={list}
          inputMode={numeric ? "numeric" : "text"}
          value={written.value[part]}
          onInput={(event) => { edit({ [part]: event.currentTarget.value }); }}
        />
      )}
    </Field>
  );
}

type ChoiceProps = Pick<ComponentProps<typeof parts.Choice>, "none" | "options"> & { part: TextPart; label: string };

/** One of some things of the plant, or none. */
export function Choice({ part, ...choice }: ChoiceProps) {
  return (
    <parts.Choice
      {...choice}
      id={`recurring-${part}`}
      complaint={complaints.value[part]}
      value={written.value[part]}
      onChosen={(value) => { edit({ [part]: value }); }}
    />
  );
}
