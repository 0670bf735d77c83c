interface Props {
  label: string;
  /** What is called for when nothing is chosen. */
  any: string;
  value: string;
  options: readonly { readonly id: string; readonly name: string }[];
  onChosen: (id: string) => void;
}

/** One of a few, or any. */
export function Choice({ any, label, onChosen, options, value }: Props) {
  return (
    <label class="narrow" data-said={value === "" ? undefined : ""}>
      <span>{label}</span>
      <select
        value={value}
        onChange={(event) => {
          onChosen(event.currentTarget.value);
        }}
      >
        <option value="">{any}</option>
        {options.map(({ id, name }) => (
          <option key={id} value={id}>
            {name}
          </option>
        ))}
      </select>
    </label>
  );
}
