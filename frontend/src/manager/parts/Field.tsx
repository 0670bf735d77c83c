import type { JSX } from "preact";

export interface FieldAttributes {
  id: string;
  "aria-invalid": boolean;
  "aria-describedby": string;
}

interface Props {
  /** Of the input, unique on its page. */
  readonly id: string;
  readonly label: JSX.Element | string;
  /** What is wrong with it; undefined for nothing. */
  readonly complaint: string | undefined;
  readonly class?: string;
  readonly children: (attributes: FieldAttributes) => JSX.Element;
}

/** A labelled field with room for what is wrong with it. */
export function Field({ children, class: more = "", complaint, id, label }: Props) {
  return (
    <div class={`field ${more}`}>
      <label for={id}>{label}</label>
      {children({ id, "aria-invalid": complaint !== undefined, "aria-describedby": `${id}-wrong` })}
      <Complaint id={id} complaint={complaint} />
    </div>
  );
}

/** What is wrong with a field, or with a part of a form. */
export function Complaint({ complaint, id }: Pick<Props, "complaint" | "id">) {
  return (
    <span id={`${id}-wrong`} class="complaint">
      {complaint}
    </span>
  );
}

interface ChoiceProps extends Omit<Props, "children"> {
  readonly value: string;
  readonly none: string;
  readonly options: readonly { id: string; name?: string }[];
  readonly onChosen: (value: string) => void;
}

/** One of some things of the plant, or none. */
export function Choice({ none, onChosen, options, value, ...field }: ChoiceProps) {
  return (
    <Field {...field}>
      {(attributes) => (
        <select {...attributes} value={value} onChange={(event) => { onChosen(event.currentTarget.value); }}>
          <option value="">{none}</option>
          {options.map(({ id, name = id }) => (
            <option key={id} value={id}>
              {name === id ? id : `${id} · ${name}`}
            </option>
          ))}
        </select>
      )}
    </Field>
  );
}
