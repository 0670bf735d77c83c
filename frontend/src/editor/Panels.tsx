/** Beside the floor: tools, what is chosen, the checks, and the shift that was played. */
import { useSignal } from "@preact/signals";
import { useLayoutEffect } from "preact/hooks";
import { format, t, word } from "../text/editor";
import { findingText } from "../text/views/findings/finding-text";
import { noteText } from "../text/views/findings/note-text";
import { act, choose, toolName } from "./acts";
import { FileField } from "./FileField";
import * as model from "./model";
import { Repair } from "./Repair";
import * as state from "./state";
import { stocksOf } from "./stocks";
import { COLUMNS, linesOf, REFERS, rowOf, rowsOf } from "./lists";
import { Entries, Lines, OneOf, Rows, Together } from "./ListFields";
import { Choice, Stocks } from "./StockFields";
import { fieldText, nameOf, whereOf, whereText } from "./where";

export function Tools() {
  return (
    <div class="card ed-tools" role="toolbar" aria-orientation="vertical" aria-label={t("tools")}>
      {state.TOOLS.map((tool) => (
        <button key={tool} type="button" class="ed-tool" aria-pressed={state.tool.value === tool} aria-keyshortcuts={state.KEYS[tool]} onClick={() => { choose(tool); }}>
          <span>{toolName(tool)}</span>
          <kbd aria-hidden="true">{state.KEYS[tool]}</kbd>
        </button>
      ))}
    </div>
  );
}

type Entry = Record<string, unknown>;

const FIELDS: Record<string, readonly string[]> = {
  nodes: ["id", "x_m", "y_m", "max_vehicle", "originals", "map"],
  lanes: ["start", "end", "speed_limit_mps", "both_ways", "types", "original", "original_back"],
  doors: ["id", "name", "lanes", "opening_s", "closes_after_s"],
  areas: ["id", "name", "polygon", "working_time"],
  machines: ["id", "name", "station", "node", "box", "makes", "working_time", "original"],
  storages: ["id", "name", "node", "box", "refill", "stocks", "original"],
  warehouses: ["id", "name", "kind", "node", "box", "stocks", "direct", "original"],
  chargers: ["id", "node", "box", "original"],
  parkings: ["id", "node", "original"],
  unassigned: ["id", "name", "node", "original"],
};

/** Fields that are written as in the file, also where they are not there yet. */
const LISTS = new Set(["makes", "stocks", "types", "working_time", "originals", "max_vehicle", "box", "polygon", "lanes", ...model.LISTS]);

/** Fields that a plant does without: left empty they are not there, and so not open. */
const OPTIONAL = new Set(["max_vehicle", "originals", "map", "original", "original_back", "working_time", "speed_limit_mps", "closes_after_s", "types"]);

/** Fields that hold a list of entries, and fields in which several values stand together. */
const ROWS = new Set(["makes", "types", "lanes", "polygon"]);
const TOGETHER = new Set(["working_time", "max_vehicle"]);

/** Words of the plant file of which one is chosen. */
const CHOICES: Record<string, readonly string[]> = { refill: ["itself", "vehicles", "none"], kind: ["source", "delivery"] };

/** What a delivery warehouse has none of: goods go there, and nothing is fetched. */
const OF_SOURCES = new Set(["stocks", "direct"]);

/** The fields of a section that an entry can have. */
function fieldsOf(section: string, entry: Entry): readonly string[] {
  const all = FIELDS[section] ?? [];
  return section === "warehouses" && entry.kind !== "source" ? all.filter((name) => !OF_SOURCES.has(name)) : all;
}

/** Leads to the field that is wanted as soon as its form is there. */
function useWanted(): void {
  const wanted = state.wanted.value;
  useLayoutEffect(() => {
    if (wanted === null) return;
    let place = document.querySelector(".ed-side");
    for (const step of wanted) place = place?.querySelector(`[data-at="${CSS.escape(step)}"]`) ?? place;
    const control = place?.querySelector<HTMLElement>("input, select, textarea, button");
    control?.focus();
    state.wanted.value = null;
  }, [wanted]);
}

export function Properties() {
  useWanted();
  const chosen = state.chosen.value;
  const data = state.data.value;
  const entry = chosen && model.entries<Entry>(data, chosen.section)[chosen.index];
  if (!chosen || !entry) {
    const kind = state.kind.value;
    const options = model.entries<Entry>(data, kind);
    return (
      <section class="card ed-side" aria-labelledby="ed-chosen">
        <h2 id="ed-chosen">{t("chosen.none")}</h2>
        <p class="muted">{t("chosen.how")}</p>
        <label data-at="kind">{t("chosen.kind")}
          <select value={kind} onChange={(event) => { state.kind.value = event.currentTarget.value; }}>
            {Object.keys(FIELDS).map((section) => <option key={section} value={section}>{word("section", section)}</option>)}
          </select>
        </label>
        <label>{t("chosen.which")}
          <select value="" onChange={(event) => { state.chosen.value = { section: kind as "nodes", index: Number(event.currentTarget.value) }; }}>
            <option value="" />
            {options.map((each, index) => <option key={index} value={index}>{nameOf(each)}</option>)}
          </select>
        </label>
        <Plan />
        <Sections />
      </section>
    );
  }
  const change = (fields: object): void => { state.draw(model.changed(data, chosen, fields)); };
  const door = chosen.section === "lanes" ? model.doorAt(data, entry as unknown as model.Lane) : -1;
  const own = state.findings.value.map((finding, index) => ({ finding, number: index + 1 })).filter(({ finding }) => finding.field.startsWith(`${chosen.section}[${chosen.index}]`));
  const fieldOf = (name: string) => {
    const note = (value: unknown): void => { change({ [name]: value }); };
    const values = CHOICES[name];
    const stocks = name === "stocks" ? stocksOf(entry.stocks) : null;
    if (values) return <Choice name={name} values={values} value={entry[name]} left={name === "refill" ? "itself" : ""} onChange={note} />;
    const refers = REFERS[name];
    if (refers) return <OneOf all={refers(data)} label={word("field", name)} value={entry[name]} onChange={(value) => { note(value ?? null); }} />;
    const rows = ROWS.has(name) ? rowsOf(entry[name]) : null;
    if (rows) return <Rows columns={COLUMNS[name] ?? []} data={data} name={name} rows={rows} onChange={(next) => { note(next.length === 0 && OPTIONAL.has(name) ? undefined : next); }} />;
    const parts = TOGETHER.has(name) ? rowOf(entry[name]) : null;
    if (parts) return <Together data={data} name={name} value={parts} onChange={note} />;
    const lines = name === "originals" ? linesOf(entry.originals) : null;
    if (lines) return <Lines name={name} value={lines} onChange={note} />;
    if (name === "box" && isBox(entry.box)) return <BoxFields box={entry.box} onChange={note} />;
    if (stocks) return <Stocks data={data} stocks={stocks} refilled={entry.refill === "vehicles"} onChange={note} />;
    return <Field name={name} value={entry[name]} onChange={note} />;
  };
  return (
    <section class="card ed-side" aria-labelledby="ed-chosen">
      <h2 id="ed-chosen">{word("section", chosen.section)} {nameOf(entry)}</h2>
      {own.map(({ finding, number }) => (
        <div key={number} class={`ed-said ed-${finding.level}`}><b>{number}</b> <b class="ed-where">{fieldText(finding.field, word)}</b> {findingText(finding)} <Repair of={finding.repair} /></div>
      ))}
      {fieldsOf(chosen.section, entry).map((name) => <div key={`${chosen.section}${chosen.index}${name}`} class="ed-at" data-at={name}>{fieldOf(name)}</div>)}
      {chosen.section === "unassigned" && (
        <fieldset>
          <legend>{t("assign")}</legend>
          {model.PLACES.filter((each) => each !== "unassigned").map((to) => (
            <button key={to} type="button" class="button small" onClick={() => {
              state.draw(model.assigned(data, chosen.index, to));
              state.chosen.value = { section: to, index: model.entries(state.data.value, to).length - 1 };
            }}>{toolName(to)}</button>
          ))}
        </fieldset>
      )}
      {chosen.section === "lanes" && (
        <button type="button" class="button" onClick={() => { state.draw(model.closedOrNot(data, chosen.index)); }}>
          {t(model.isClosed(data, entry as unknown as model.Lane) ? "lane.open" : "lane.close")}
        </button>
      )}
      {chosen.section === "lanes" && (
        <button type="button" class="button" onClick={() => { state.draw(model.doorOrNot(data, chosen.index)); }}>
          {t(door >= 0 ? "lane.noDoor" : "lane.door")}
        </button>
      )}
      {door >= 0 && (
        <button type="button" class="button" onClick={() => { state.chosen.value = { section: "doors", index: door }; }}>
          {t("lane.itsDoor", { name: nameOf(model.entries<Entry>(data, "doors")[door] ?? null) })}
        </button>
      )}
      <div class="ed-row">
        <button type="button" class="button" onClick={() => { act({ kind: "remove" }); }}>{t("remove")}</button>
        <button type="button" class="button" onClick={() => { state.chosen.value = null; }}>{t("done")}</button>
      </div>
    </section>
  );
}

const SIDES = ["x_m", "y_m", "width_m", "depth_m"] as const;

/** Whether a value is a box of which some sides may be open. */
function isBox(value: unknown): value is Partial<model.Box> | null | undefined {
  return value === null || value === undefined || (typeof value === "object" && !Array.isArray(value));
}

/** Middle and size of what stands on the floor. */
function BoxFields({ box, onChange }: { box: Partial<model.Box> | null | undefined; onChange: (value: unknown) => void }) {
  return (
    <fieldset class="ed-rows">
      <legend>{word("field", "box")}</legend>
      <div class="ed-box">
        {SIDES.map((side) => (
          <label key={side} data-at={side}>{word("column", side)}
            <input type="number" step="any" min={side === "x_m" || side === "y_m" ? undefined : 0} value={box?.[side] ?? ""} onChange={(event) => {
              const said = event.currentTarget.value;
              onChange({ ...box, [side]: said === "" ? null : Number(said) });
            }} />
          </label>
        ))}
      </div>
    </fieldset>
  );
}

function Field({ name, value, onChange }: { name: string; value: unknown; onChange: (value: unknown) => void }) {
  const wrong = useSignal(false);
  // What is being typed stays, whatever comes of the draft meanwhile.
  const typed = useSignal<string | null>(null);
  const forget = (): void => { typed.value = null; };
  const note = (event: { currentTarget: { value: string } }): void => { typed.value = event.currentTarget.value; };
  const label = word("field", name);
  if (typeof value === "boolean" || name === "both_ways" || name === "direct") {
    return <label class="ed-check"><input type="checkbox" checked={value === true} onChange={(event) => { onChange(event.currentTarget.checked); }} /> {label}</label>;
  }
  const empty = OPTIONAL.has(name) ? undefined : null;
  if ((typeof value === "object" && value !== null) || LISTS.has(name)) {
    return (
      <label>{label}
        <textarea rows={name === "box" ? 2 : 3} aria-invalid={wrong.value} value={typed.value ?? (value === undefined || value === null ? "" : JSON.stringify(value))} onInput={note} onChange={(event) => {
          try {
            onChange(event.currentTarget.value === "" ? empty : JSON.parse(event.currentTarget.value));
            wrong.value = false;
            forget();
          } catch {
            wrong.value = true;
          }
        }} />
        {wrong.value && <small role="alert" class="complaint">{t("json.wrong")}</small>}
      </label>
    );
  }
  const number = typeof value === "number" || name.endsWith("_m") || name.endsWith("_mps") || name.endsWith("_s");
  const shown = typed.value ?? (typeof value === "string" || typeof value === "number" ? value : "");
  const tell = (text: string): void => { forget(); onChange(text === "" ? empty : number ? Number(text) : text); };
  return (
    <label>{label}
      {number
        ? <input type="number" step="any" value={shown} onInput={note} onBlur={forget} onChange={(event) => { tell(event.currentTarget.value); }} />
        : <input type="text" value={shown} onInput={note} onBlur={forget} onChange={(event) => { tell(event.currentTarget.value); }} />}
    </label>
  );
}

/** A picture under the draft: PNG, SVG or DXF. */
function Plan() {
  const plan = state.data.value.plan as model.Plan | undefined;
  const width_m = Number(state.data.value.width_m) || 60;
  const failed = useSignal("");
  const laid = useSignal<state.Laid | null>(null);
  const reading = useSignal(false);
  const change = (fields: Partial<model.Plan>): void => {
    if (plan) state.draw({ ...state.data.value, plan: { ...plan, ...fields } });
  };
  return (
    <fieldset>
      <legend>{t("plan")}</legend>
      <FileField label={t("plan.file")} accept="image/png,image/svg+xml,.dxf" disabled={reading.value} onFile={(file) => {
        reading.value = true;
        failed.value = "";
        laid.value = null;
        state.layPlan(file).then(
          (found) => {
            laid.value = found;
            const wide_m = found?.width_m ?? null;
            // A plan that says how large it is lies as large as that; another one keeps its place.
            if (!plan || wide_m !== null) state.draw({ ...state.data.value, plan: { x_m: 0, y_m: 0, opacity: 0.6, ...plan, width_m: wide_m ?? width_m } });
          },
          (error: unknown) => { failed.value = (error as Error).message; },
        ).finally(() => { reading.value = false; });
      }} />
      {reading.value && <small role="status">{t("plan.reading")}</small>}
      {failed.value && <small role="alert" class="complaint">{failed.value}</small>}
      {laid.value?.width_m != null && <small role="status">{t("plan.size", { width: format.number(laid.value.width_m, 1), height: format.number(laid.value.height_m ?? 0, 1) })}</small>}
      {(laid.value?.notes.length ?? 0) > 0 && <ul class="muted">{laid.value?.notes.map((note) => <li key={note.text}>{noteText(note)}</li>)}</ul>}
      {plan && (["x_m", "y_m", "width_m"] as const).map((name) => <Field key={name} name={name} value={plan[name]} onChange={(value) => { change({ [name]: Number(value) || 0 }); }} />)}
      {plan && <label>{t("plan.opacity")}<input type="range" min={0} max={1} step={0.05} value={plan.opacity} onChange={(event) => { change({ opacity: Number(event.currentTarget.value) }); }} /></label>}
    </fieldset>
  );
}

/** Sections that have no place on the floor. */
function Sections() {
  const data = state.data.value;
  // What is typed here belongs here, also when it is told after another list was chosen.
  const shown = state.listed.value.section;
  const value = data[shown];
  const rows = rowsOf(value);
  const note = (next: unknown): void => { state.draw({ ...state.data.value, [shown]: next }); };
  return (
    <fieldset data-at="lists">
      <legend>{t("sections")}</legend>
      <label>{t("sections.which")}
        <select value={shown} onChange={(event) => { state.listed.value = { section: event.currentTarget.value as "materials", index: 0 }; }}>
          {model.LISTS.map((each) => <option key={each} value={each}>{word("section", each)}</option>)}
        </select>
      </label>
      {rows ? <Entries key={shown} data={data} rows={rows} section={shown} onChange={note} /> : <Field key={shown} name={shown} value={value} onChange={note} />}
    </fieldset>
  );
}

/** Whether there is a form for what a finding is about. */
function leads({ field }: state.Finding): boolean {
  const { chosen, listed, whole } = whereOf(field);
  return (chosen ?? listed ?? whole) !== null;
}

export function Checks() {
  const all = state.findings.value;
  const show = ({ field }: state.Finding): void => {
    const { chosen: about, listed, steps, whole } = whereOf(field);
    const list = model.LISTS.find((each) => each === whole);
    state.tool.value = "choose";
    state.chosen.value = about;
    if (listed ?? list) state.listed.value = listed ?? { section: list ?? "materials", index: 0 };
    else if (whole) state.kind.value = whole;
    state.wanted.value = about ? steps : whole && !list ? ["kind"] : ["lists", ...steps];
    const spot = about && model.spotOf(state.data.value, about);
    if (spot) state.cursor.value = spot;
  };
  return (
    <section class="card ed-checks" aria-labelledby="ed-checks">
      <header class="card-head">
        <h2 id="ed-checks">{t("checks")}</h2>
        <span class="count">{all.length}</span>
        <span class="muted">{t("checks.as")}</span>
      </header>
      {all.length === 0 ? <p class="empty">{t("checks.none")}</p> : (
        <ol tabIndex={0} aria-label={t("checks")}>
          {all.map((finding, index) => (
            <li key={index}>
              <span class={`tag ed-${finding.level}`}>{t(`level.${finding.level as "error"}`)}</span>
              <b>{index + 1}</b>
              <span><b class="ed-where">{whereText(finding.field, state.data.value, word)}</b> {findingText(finding)} <Repair of={finding.repair} /></span>
              {leads(finding) && <button type="button" class="button small" aria-label={t("checks.showOf", { number: String(index + 1) })} onClick={() => { show(finding); }}>{t("checks.show")}</button>}
            </li>
          ))}
        </ol>
      )}
    </section>
  );
}

export function PlayPanel() {
  const played = state.play.value;
  const hours = useSignal(2);
  const failed = useSignal("");
  const faults = state.findings.value.some(({ level }) => level !== "warning");
  const old = played !== null && played.state === "done" && (played.version !== state.draft.value?.version || state.kept.value !== "kept");
  const begin = (): void => {
    failed.value = "";
    state.playShift(hours.value, 1).catch((error: unknown) => { failed.value = (error as Error).message; });
  };
  return (
    <section class="card ed-play" aria-labelledby="ed-play">
      <header class="card-head">
        <h2 id="ed-play">{t("play.title")}</h2>
        {old && <span class="tag ed-warning">{t("play.older")}</span>}
      </header>
      <div class="ed-row">
        <label>{t("play.hours")} <input type="number" min={0.1} max={8} step={0.1} value={hours.value} onChange={(event) => { hours.value = Number(event.currentTarget.value) || 1; }} /></label>
        <button type="button" class="button primary" disabled={faults || played?.state === "playing"} onClick={begin}>{t("play.do")}</button>
      </div>
      {faults && <p class="muted">{t("play.faults")}</p>}
      {failed.value && <p role="alert" class="complaint">{failed.value}</p>}
      <div role="status">
        {played?.state === "playing" && <p>{t("play.playing")} <progress aria-label={t("play.playing")} /></p>}
        {played?.state === "failed" && <p class="complaint">{t("play.failed", { reason: findingText({ text: played.reason, code: played.reason_code, values: played.reason_values }) })}</p>}
        {played?.state === "done" && played.draft && played.running && <Result draft={played.draft} running={played.running} hours={played.hours} />}
      </div>
    </section>
  );
}

type Figures = NonNullable<state.Play["draft"]>;

function Result({ draft, running, hours }: { draft: Figures; running: Figures; hours: number }) {
  const percent = (frac: number | null): string => (frac === null ? "–" : format.percent(frac, 1));
  const rows: [string, string, string][] = [
    [t("play.onTime"), percent(draft.on_time_frac), percent(running.on_time_frac)],
    [t("play.starving"), percent(draft.starvation_frac), percent(running.starvation_frac)],
    [t("play.transports"), format.number(draft.transports_per_h, 1), format.number(running.transports_per_h, 1)],
    [t("play.waiting"), percent(draft.waiting_frac), percent(running.waiting_frac)],
  ];
  return (
    <>
      <p class="muted">{t("play.same", { hours: format.number(hours, 1), orders: format.count(draft.orders_placed) })}</p>
      <dl class="ed-figures">
        {rows.map(([name, ours, theirs]) => (
          <div key={name}>
            <dt>{name}</dt>
            <dd><b>{ours}</b> <small>{t("play.beside", { value: theirs })}</small></dd>
          </div>
        ))}
      </dl>
      <p><b>{t("play.bottleneck")}</b> {findingText({ text: draft.bottleneck, code: draft.bottleneck_code, values: draft.bottleneck_values })}</p>
      <p class="ed-next"><b>{t("play.next")}</b> {t("play.nextHow")}</p>
    </>
  );
}
