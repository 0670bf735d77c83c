import { Later } from "../../../parts/Later";
import { t, word } from "../../../text/views/records";
import { narrow } from "../../parts/pages/paged";
import { AskedMoment, AskedWords } from "../../parts/filters/Asked";
import { Choice } from "../../parts/filters/Choice";
import { CsvLink } from "../../parts/filters/CsvLink";
import { ACTIONS, NOTHING, RESULTS, tableOf } from "./filter";
import { filter, oldestFirst } from "./log";

/** What is wanted of the log; a table of just that may be downloaded. */
export function Filters() {
  return (
    <>
      <AskedWords />
      <AskedMoment name="since" label={t("audit.since")} />
      <AskedMoment name="until" label={t("audit.until")} />
      <Words name="who" />
      <Words name="target" />
      <Choice
        label={t("audit.action")}
        any={t("filter.any")}
        value={filter.value.action}
        options={ACTIONS.map((id) => ({ id, name: word("audit.did", id) }))}
        onChosen={(action) => { narrow({ action }); }}
      />
      <Choice
        label={t("audit.result")}
        any={t("filter.any")}
        value={filter.value.result}
        options={RESULTS.map((id) => ({ id, name: word("audit.came", id) }))}
        onChosen={(result) => { narrow({ result }); }}
      />
      <button type="button" class="button" onClick={() => { narrow({ ...NOTHING, sort: "" }); }}>
        {t("audit.clear")}
      </button>
      <CsvLink href={tableOf(filter.value, oldestFirst.value)} />
      <Later load={async () => (await import("../../parts/kept/KeptSheet")).load()} />
    </>
  );
}

function Words({ name }: { name: "who" | "target" }) {
  return (
    <label class="narrow" data-said={filter.value[name] === "" ? undefined : ""}>
      <span>{t(`audit.${name}`)}</span>
      <input type="search" size={10} value={filter.value[name]} onChange={(event) => { narrow({ [name]: event.currentTarget.value }); }} />
    </label>
  );
}
