/** Lists of the plant file as forms: an entry is chosen and filled in; short lists within one stand under one another. */
import { t, word } from "../text/editor";
import { BEGINS, calledOf, COLUMNS, type Column, DAYS, type Row, together, valueOf, withRow, withValue, writtenOf } from "./lists";
import type { Data } from "./model";
import * as state from "./state";

interface Listed {
  readonly data: Data;
  readonly rows: readonly Row[];
  readonly onChange: (rows: readonly Row[]) => void;
}

/** A section without a place on the floor. */
export function Entries({ data, rows, section, onChange }: Listed & { section: string }) {
  const columns = COLUMNS[section] ?? [];
  const index = Math.min(state.listed.value.index, rows.length - 1);
  const show = (at: number): void => { state.listed.value = { ...state.listed.value, index: at }; };
  const row = rows[index];
  return (
    <>
      <label>{t("entries.which")}
        <select value={index} disabled={rows.length === 0} onChange={(event) => { show(Number(event.currentTarget.value)); }}>
          {rows.map((each, number) => <option key={number} value={number}>{writtenOf(each.id) || "?"}</option>)}
        </select>
      </label>
      {row && <Columns key={index} columns={columns} data={data} row={row} onChange={(next) => { onChange(replaced(rows, index, next)); }} />}
      <div class="ed-row">
        <button type="button" class="button" onClick={() => {
          show(rows.length);
          onChange(withRow(data, columns, rows, BEGINS[section] ?? ""));
        }}>{t("entries.new")}</button>
        {row && <button type="button" class="button" aria-label={t("stock.removeOf", { item: writtenOf(row.id) })} onClick={() => { onChange(without(rows, index)); }}>{t("remove")}</button>}
      </div>
    </>
  );
}

/** A list within an entry, as the bill of a product or what a machine makes. */
export function Rows({ columns, data, name, rows, onChange }: Listed & { columns: readonly Column[]; name: string }) {
  return (
    <fieldset class="ed-rows">
      <legend>{word("field", name)}</legend>
      {rows.map((row, index) => {
        const called = calledOf(columns, row);
        return (
          <div key={index} class="ed-stock" role="group" aria-label={called} data-at={index}>
            <Columns columns={columns} data={data} row={row} onChange={(next) => { onChange(replaced(rows, index, next)); }} />
            <button type="button" class="button small" aria-label={t("stock.removeOf", { item: called })} onClick={() => { onChange(without(rows, index)); }}>×</button>
          </div>
        );
      })}
      <button type="button" class="button" onClick={() => { onChange(withRow(data, columns, rows, "")); }}>{t("entries.add")}</button>
    </fieldset>
  );
}

/** What stands together in a field of an entry, as its working time; not in the file where all of it is left empty. */
export function Together({ data, name, value, onChange }: { data: Data; name: string; value: Row; onChange: (value: unknown) => void }) {
  const columns = COLUMNS[name] ?? [];
  return (
    <fieldset class="ed-rows">
      <legend>{word("field", name)}</legend>
      <div class={name === "max_vehicle" ? "ed-box" : "ed-rows"}>
        <Columns columns={columns} data={data} row={value} onChange={(row) => { onChange(together(columns, row)); }} />
      </div>
    </fieldset>
  );
}

/** Lines of text, one for each. */
export function Lines({ name, value, onChange }: { name: string; value: readonly string[]; onChange: (value: unknown) => void }) {
  const column = COLUMNS[name]?.[0];
  return (
    <label>{word("field", name)}
      <textarea rows={Math.max(2, value.length)} value={value.join("\n")} onChange={(event) => { if (column) onChange(valueOf(column, event.currentTarget.value)); }} />
    </label>
  );
}

/** Days of the week; none said is all of them. */
function Days({ value, onChange }: { value: unknown; onChange: (value: unknown) => void }) {
  const on: readonly unknown[] = Array.isArray(value) ? value : DAYS;
  return (
    <div class="ed-days" role="group" aria-label={word("column", "days")}>
      {DAYS.map((day) => (
        <label key={day} class="ed-check">
          <input type="checkbox" checked={on.includes(day)} onChange={(event) => {
            const checked = event.currentTarget.checked;
            onChange(DAYS.filter((each) => (each === day ? checked : on.includes(each))));
          }} /> {word("day", day)}
        </label>
      ))}
    </div>
  );
}

const replaced = (rows: readonly Row[], index: number, row: Row): readonly Row[] => rows.map((each, at) => (at === index ? row : each));
const without = (rows: readonly Row[], index: number): readonly Row[] => rows.filter((_, at) => at !== index);

function Columns({ columns, data, row, onChange }: { columns: readonly Column[]; data: Data; row: Row; onChange: (row: Row) => void }) {
  const field = (column: Column) => {
    const value = row[column.name];
    const note = (said: unknown): void => { onChange(withValue(row, column, said)); };
    if (column.kind === "rows") return <Rows columns={column.columns ?? []} data={data} name={column.name} rows={Array.isArray(value) ? (value as Row[]) : []} onChange={note} />;
    if (column.kind === "days") return <Days value={value} onChange={note} />;
    if (column.kind === "choice") return <OneOf all={column.from?.(data) ?? []} label={word("column", column.name)} value={value} onChange={note} />;
    return <Written column={column} value={value} onChange={note} />;
  };
  return (
    <>
      {columns.map((column) => <div key={column.name} class="ed-at" data-at={column.name}>{field(column)}</div>)}
    </>
  );
}

/** One of what the plant has; empty as long as nobody has said which, and what it has not is shown as it stands there. */
export function OneOf({ all, label, value, onChange }: { all: readonly string[]; label: string; value: unknown; onChange: (value: string | undefined) => void }) {
  const said = writtenOf(value);
  return (
    <label>{label}
      <select value={said} onChange={(event) => { onChange(event.currentTarget.value || undefined); }}>
        {!all.includes(said) && <option value={said}>{said}</option>}
        {all.map((each) => <option key={each} value={each}>{each}</option>)}
      </select>
    </label>
  );
}

function Written({ column, value, onChange }: { column: Column; value: unknown; onChange: (value: unknown) => void }) {
  const said = writtenOf(value);
  const note = (event: { currentTarget: { value: string } }): void => { onChange(valueOf(column, event.currentTarget.value)); };
  return (
    <label>{word("column", column.label ?? column.name)}
      {column.kind === "count" || column.kind === "number"
        ? <input type="number" min={0} step={column.kind === "count" ? 1 : "any"} value={said} onChange={note} />
        : column.kind === "time" ? <input type="time" value={said} onChange={note} /> : <input type="text" value={said} onChange={note} />}
    </label>
  );
}
