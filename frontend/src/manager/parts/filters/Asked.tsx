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
export function AskedMoment(props: TimeProps) {
  return <AskedTime {...props} type="datetime-local" last="9999-12-31T23:59" />;
}

/** A day, in the reader's zone. */
export function AskedDay(props: TimeProps) {
  return <AskedTime {...props} type="date" last="9999-12-31" />;
}

interface TimeProps {
  name: string;
  label: string;
}

/** @param props.last with it a year has four digits, and who has typed them goes on to what comes after it */
function AskedTime({ label, last, name, type }: TimeProps & { type: "date" | "datetime-local"; last: string }) {
  const said = asked.value[name] ?? "";
  return (
    <label class="narrow" data-said={said === "" ? undefined : ""}>
      <span>{label}</span>
      <input
        type={type}
        max={last}
        value={type === "date" ? said.slice(0, last.length) : said}
        onInput={(event) => {
          // Each digit of a year makes another time: no steps to go back over.
          narrow({ [name]: event.currentTarget.value }, "replace");
        }}
      />
    </label>
  );
}
