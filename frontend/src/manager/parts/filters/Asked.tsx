/** Filters whose values stand in the address. */
import { t } from "../../../text/manager";
import { narrow } from "../pages/paged";
import { asked } from "../../views";
import { Choice } from "./Choice";

/** Words that are looked for in all there ever was. */
export function AskedWords() {
  return (
    <input
      class="filter"
      data-said={(asked.value.q ?? "") === "" ? undefined : ""}
      type="search"
      maxLength={200}
      aria-label={t("filter.findAll")}
      placeholder={t("filter.findAll")}
      value={asked.value.q ?? ""}
      onInput={(event) => {
        narrow({ q: event.currentTarget.value }, "replace");
      }}
    />
  );
}

interface ChoiceProps {
  name: string;
  label: string;
  options: readonly { readonly id: string; readonly name: string }[];
}

export function AskedChoice({ label, name, options }: ChoiceProps) {
  return (
    <Choice
      label={label}
      any={t("filter.any")}
      value={asked.value[name] ?? ""}
      options={options}
      onChosen={(id) => {
        narrow({ [name]: id });
      }}
    />
  );
}

export function AskedOnly({ label, name }: { name: string; label: string }) {
  return (
    <label class="narrow only" data-said={asked.value[name] === "yes" ? "" : undefined}>
      <input
        type="checkbox"
        checked={asked.value[name] === "yes"}
        onChange={(event) => {
          narrow({ [name]: event.currentTarget.checked ? "yes" : "" });
        }}
      />
      <span>{label}</span>
    </label>
  );
}

/** A day and time, in the reader's zone. */
export function AskedMoment({ label, name }: { name: string; label: string }) {
  return (
    <label class="narrow" data-said={(asked.value[name] ?? "") === "" ? undefined : ""}>
      <span>{label}</span>
      <input
        type="datetime-local"
        value={asked.value[name] ?? ""}
        onChange={(event) => {
          narrow({ [name]: event.currentTarget.value });
        }}
      />
    </label>
  );
}
