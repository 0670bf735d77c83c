import { t } from "../../../text/views/recurring";
import { plant } from "../../state";
import { type Line, NO_LINE } from "./draft";
import { Complaint } from "./fields";
import { complaints, edit, lines as shownLines } from "./form";

/** What an order is for: products and how many pieces of each. */
export function OrderLines() {
  const lines = shownLines.value;
  const products = plant.value?.products ?? [];
  const change = (index: number, by: Partial<Line>): void => {
    edit({ lines: lines.map((line, i) => (i === index ? { ...line, ...by } : line)) });
  };
  return (
    <fieldset>
      <legend>{t("recurring.lines")}</legend>
      {lines.map((line, i) => {
        const attributes = { "aria-invalid": complaints.value[`line.${i}`] !== undefined, "aria-describedby": `recurring-line.${i}-wrong` };
        return (
          <div key={i} class="recurring-line">
            <select {...attributes} aria-label={t("recurring.productOf", { row: i + 1 })} value={line.product} onChange={(event) => { change(i, { product: event.currentTarget.value }); }}>
              <option value="">{t("recurring.choose")}</option>
              {products.map(({ id, name }) => (
                <option key={id} value={id}>
                  {name}
                </option>
              ))}
            </select>
            <input
              {...attributes}
              aria-label={t("recurring.piecesOf", { row: i + 1 })}
              inputMode="numeric"
              autoComplete="off"
              placeholder={t("recurring.pieces")}
              value={line.quantity}
              onInput={(event) => { change(i, { quantity: event.currentTarget.value }); }}
            />
            {lines.length > 1 && (
              <button type="button" class="button small" aria-label={t("recurring.dropLine", { row: i + 1 })} onClick={() => { edit({ lines: lines.filter((_, j) => j !== i) }); }}>
                ×
              </button>
            )}
            <Complaint part={`line.${i}`} />
          </div>
        );
      })}
      <Complaint part="lines" />
      <button type="button" class="button small" onClick={() => { edit({ lines: [...lines, NO_LINE] }); }}>
        {t("recurring.addLine")}
      </button>
    </fieldset>
  );
}
