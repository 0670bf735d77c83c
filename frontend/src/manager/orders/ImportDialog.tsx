import { format, n, t } from "../../text/manager";
import { Sheet } from "../parts/Sheet";
import { busy, choose, failed, fileName, found, place, placed, ready } from "./import";

const ID = "orders-import";

export function ImportButton() {
  return (
    <button type="button" class="button" popovertarget={ID}>
      {t("import.open")}
    </button>
  );
}

/** Places the orders of a spreadsheet: first it is looked through, and told what is wrong in which row. */
export function ImportDialog() {
  const faults = found.value?.faults ?? [];
  return (
    <Sheet id={ID} title={t("import.title")}>
      <p class="muted">{t("import.hint")}</p>
      <p>
        <label class="button import-file">
          {t("import.choose")}
          <input
            type="file"
            accept=".csv,text/csv"
            onChange={(event) => {
              const input = event.currentTarget;
              void choose(input.files?.[0]);
              // The same file, corrected, may be chosen again.
              input.value = "";
            }}
          />
        </label>{" "}
        {fileName.value}
      </p>
      <div role="status">
        {failed.value !== "" && <p class="complaint">{failed.value}</p>}
        {placed.value !== null && (
          <p class="outcome-good">{n("import.placed", placed.value, format.count(placed.value))}</p>
        )}
        {ready.value > 0 && <p>{n("import.ready", ready.value, format.count(ready.value))}</p>}
        {faults.length > 0 && <p class="complaint">{n("import.faults", faults.length)}</p>}
      </div>
      {faults.length > 0 && (
        <table>
          <thead>
            <tr>
              <th scope="col">{t("import.row")}</th>
              <th scope="col">{t("import.column")}</th>
              <th scope="col">{t("import.reason")}</th>
            </tr>
          </thead>
          <tbody>
            {faults.map(({ column, reason, row }, i) => (
              <tr key={i}>
                <th scope="row">{format.count(row)}</th>
                <td>{column}</td>
                <td>{reason}</td>
              </tr>
            ))}
          </tbody>
        </table>
      )}
      {ready.value > 0 && (
        <p>
          <button type="button" class="button primary" disabled={busy.value} onClick={() => void place()}>
            {t("import.place")}
          </button>
        </p>
      )}
    </Sheet>
  );
}
