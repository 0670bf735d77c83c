/** What a chosen storage or warehouse keeps, and how it comes there. */
import { format, t, word } from "../text/editor";
import type { Data } from "./model";
import { keepable, type Stock, warehousesOf, withChanged, withStock } from "./stocks";

/** One of some words of the plant file; `left` counts where it is left out, and what is empty then nobody has said. */
export function Choice({ name, values, value, left, onChange }: { name: string; values: readonly string[]; value: unknown; left: string; onChange: (value: string | null) => void }) {
  const said = typeof value === "string" ? value : left;
  return (
    <label>{word("field", name)}
      <select value={said} onChange={(event) => { onChange(event.currentTarget.value || null); }}>
        {!values.includes(said) && <option value={said}>{said}</option>}
        {values.map((each) => <option key={each} value={each}>{word(name, each)}</option>)}
      </select>
    </label>
  );
}

/** The stocks of a place, a line for each. Points and lots are asked for only where vehicles refill it. */
export function Stocks({ data, stocks, refilled, onChange }: { data: Data; stocks: readonly Stock[]; refilled: boolean; onChange: (stocks: readonly Stock[]) => void }) {
  const all = keepable(data).map(({ id }) => id);
  return (
    <fieldset class="ed-stocks">
      <legend>{word("field", "stocks")}</legend>
      {stocks.map((stock, index) => {
        const material = stock.material ?? "";
        const change = (fields: Stock): void => { onChange(withChanged(stocks, index, fields)); };
        const from = warehousesOf(data, material);
        return (
          <div key={index} class="ed-stock" role="group" aria-label={material} data-at={index}>
            <select aria-label={t("stock.material")} value={material} onChange={(event) => { change({ material: event.currentTarget.value }); }}>
              {!all.includes(material) && <option value={material}>{material}</option>}
              {all.map((id) => <option key={id} value={id}>{id}</option>)}
            </select>
            <button type="button" class="button small" aria-label={t("stock.removeOf", { item: material })} onClick={() => { onChange(stocks.filter((_, at) => at !== index)); }}>×</button>
            <Count label={t("stock.capacity")} value={stock.capacity} onChange={(capacity) => { change({ capacity }); }} />
            {refilled && <Count label={t("stock.reorder_point")} value={stock.reorder_point} onChange={(point) => { change({ reorder_point: point }); }} />}
            {refilled && <Count label={t("stock.lot")} value={stock.lot} onChange={(lot) => { change({ lot }); }} />}
            {refilled && <small class="muted">{from.length > 0 ? t("stock.from", { places: format.list(from) }) : t("stock.nowhere")}</small>}
          </div>
        );
      })}
      <button type="button" class="button" disabled={withStock(data, stocks) === stocks} onClick={() => { onChange(withStock(data, stocks)); }}>{t("stock.add")}</button>
    </fieldset>
  );
}

function Count({ label, value, onChange }: { label: string; value: number | null | undefined; onChange: (value: number | null) => void }) {
  return (
    <label>{label}
      <input type="number" min={0} step={1} value={value ?? ""} onChange={(event) => { onChange(event.currentTarget.value === "" ? null : Number(event.currentTarget.value)); }} />
    </label>
  );
}
