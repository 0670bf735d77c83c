import { format, n, t } from "../../text/views/order";
import { FileChoice } from "../parts/FileChoice";
import { RowFaults } from "../parts/RowFaults";
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
  const hints = placed.value === null ? (found.value?.hints ?? []) : [];
  return (
    <Sheet id={ID} title={t("import.title")}>
      <p class="muted">{t("import.hint")}</p>
      <FileChoice name={fileName.value} onChosen={(file) => void choose(file)} />
      <div role="status">
        {failed.value !== "" && <p class="complaint">{failed.value}</p>}
        {placed.value !== null && (
          <p class="outcome-good">{n("import.placed", placed.value, format.count(placed.value))}</p>
        )}
        {ready.value > 0 && <p>{n("import.ready", ready.value, format.count(ready.value))}</p>}
        {faults.length > 0 && <p class="complaint">{n("import.faults", faults.length)}</p>}
      </div>
      <RowFaults faults={faults} />
      {hints.length > 0 && <p>{n("import.hints", hints.length)}</p>}
      <RowFaults faults={hints} />
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
