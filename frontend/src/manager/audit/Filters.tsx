import { t, word } from "../../text/manager";
import { ACTIONS, NOTHING, queryOf, RESULTS } from "./filter";
import { filter, lookAgain, narrow } from "./log";

/** What is wanted of the log; a table of just that may be downloaded. */
export function Filters() {
  return (
    <>
      <Moment name="since" />
      <Moment name="until" />
      <Words name="who" />
      <Words name="target" />
      <Choice name="action" group="audit.did" words={ACTIONS} />
      <Choice name="result" group="audit.came" words={RESULTS} />
      <button type="button" class="button" onClick={() => { narrow(NOTHING); }}>
        {t("audit.clear")}
      </button>
      <button type="button" class="button" onClick={lookAgain}>
        {t("audit.again")}
      </button>
      <a class="button" href={`/api/audit?${queryOf(filter.value, { format: "csv" })}`} download="audit.csv" title={t("audit.csvTitle")}>
        {t("audit.csv")}
      </a>
    </>
  );
}

function Moment({ name }: { name: "since" | "until" }) {
  return (
    <label class="narrow">
      <span>{t(`audit.${name}`)}</span>
      <input type="datetime-local" value={filter.value[name]} onChange={(event) => { narrow({ [name]: event.currentTarget.value }); }} />
    </label>
  );
}

function Words({ name }: { name: "who" | "target" }) {
  return (
    <label class="narrow">
      <span>{t(`audit.${name}`)}</span>
      <input type="search" size={10} value={filter.value[name]} onChange={(event) => { narrow({ [name]: event.currentTarget.value }); }} />
    </label>
  );
}

function Choice({ group, name, words }: { name: "action" | "result"; group: string; words: readonly string[] }) {
  return (
    <label class="narrow">
      <span>{t(`audit.${name}`)}</span>
      <select value={filter.value[name]} onChange={(event) => { narrow({ [name]: event.currentTarget.value }); }}>
        <option value="">{t("audit.any")}</option>
        {words.map((each) => (
          <option key={each} value={each}>
            {word(group, each)}
          </option>
        ))}
      </select>
    </label>
  );
}
