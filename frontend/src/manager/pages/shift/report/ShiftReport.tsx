import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { nowS } from "../../../../stream/stream";
import { speakAlso } from "../../../../text/speech";
import { tables as recordTables } from "../../../../text/views/records";
import { tables as replayTables } from "../../../../text/views/replay";
import { format, t, tables, word } from "../../../../text/views/shift";
import { KeptNote } from "../../../parts/kept/KeptNote";
import { useRefreshed } from "../../../refreshed";
import { me } from "../../../shell/session";
import { ask, asked } from "../../../views";
import { csvOf, fetchReport, fetchTargets } from "./api";
import { FiguresTable } from "./FiguresTable";
import { Head } from "./Head";
import "./shift.css";
import { type Against, GROUPS, neighbour, type Report, type Shift, shiftAt, shiftOf, type Targets } from "./shifts";
import { DrillDown, Happened } from "./Tables";
import { TARGETS_ID, TargetsSheet } from "./TargetsSheet";
import { Use } from "./Use";

const AGAIN_MS = 60_000;
const AGAINST = ["day", "before", "week"] as const;

/** The page, once it has its words. */
export async function load(): Promise<typeof ShiftReport> {
  await Promise.all([speakAlso(recordTables), speakAlso(replayTables), speakAlso(tables)]);
  return ShiftReport;
}

interface Answer {
  report: Report;
  targets: Targets;
  shift: Shift;
}

function askedAgainst(): Against {
  return AGAINST.find((each) => each === asked.value.against) ?? "day";
}

async function read(): Promise<Answer> {
  // What the address says is read before anything is awaited: a change of it asks anew.
  const { from, until } = asked.value;
  const against = askedAgainst();
  const targets = await fetchTargets();
  const shift = shiftOf(targets.shifts, from, until, nowS.peek());
  return { targets, shift, report: await fetchReport(shift, against) };
}

function show(shift: Shift): void {
  ask({ from: new Date(shift.fromS * 1000).toISOString(), until: new Date(shift.untilS * 1000).toISOString() });
}

/** What came of a shift: two pages of A4 when it is printed. */
export function ShiftReport() {
  const { again, answer, failed } = useRefreshed(read, AGAIN_MS);
  const found = answer.value;
  useEffect(() => {
    const before = document.title;
    if (found) document.title = `${t("shift.title")} ${format.day(found.shift.fromS)}`;
    return () => {
      document.title = before;
    };
  }, [found]);
  return (
    <main class="shift-view" id="content" tabIndex={-1} aria-busy={!found && failed.value === null}>
      <header class="shift-bar-top">
        <a class="link" href="#kpis">{t("shift.back")}</a>
        {found && <Choose {...found} />}
        <span class="table-aside shift-deeds">
          {found && (
            <a class="button" href={csvOf(found.shift, askedAgainst())} download>
              {t("promises.csv")}
            </a>
          )}
          {me.value?.scopes.includes("floor:write") === true && (
            <button type="button" class="button" popovertarget={TARGETS_ID}>{t("shift.targets")}</button>
          )}
          <button type="button" class="button primary" onClick={() => { print(); }}>{t("shift.print")}</button>
        </span>
      </header>
      {failed.value !== null && <p class="shift-note tone-alarm" role="alert">{t("shift.failed", { reason: failed.value })}</p>}
      {!found && failed.value === null && <p class="empty" role="status">{t("shift.loading")}</p>}
      {found && <Paper {...found} />}
      {found && <TargetsSheet key={JSON.stringify(found.targets.targets)} figures={found.report.figures} targets={found.targets} onSaved={again} />}
    </main>
  );
}

function Choose({ shift, targets }: Answer) {
  const begins = targets.shifts;
  const later = neighbour(begins, shift, 1);
  return (
    <>
      <span class="segments" role="group" aria-label={t("shift.which")}>
        <button type="button" aria-label={t("shift.earlier")} onClick={() => { show(neighbour(begins, shift, -1)); }}>‹</button>
        {begins.map(({ begin_min, name }) => (
          <button key={name} type="button" aria-pressed={shift.name === name} onClick={() => { show(lastOf(begins, begin_min, shift)); }}>
            {word("shift.name", name)}
          </button>
        ))}
        <button type="button" aria-label={t("shift.later")} disabled={later.fromS > nowS.value} onClick={() => { show(later); }}>›</button>
      </span>
      <Own shift={shift} />
      <span class="segments" role="group" aria-label={t("shift.against")}>
        {AGAINST.map((each) => (
          <button key={each} type="button" aria-pressed={askedAgainst() === each} onClick={() => { ask({ against: each }); }}>
            {t(`shift.against.${each}`)}
          </button>
        ))}
      </span>
    </>
  );
}

/** The shift that begins at this time of the day that is shown, or of the day before where that is still to come. */
function lastOf(begins: Targets["shifts"], minutes: number, { fromS }: Shift): Shift {
  const day = new Date(fromS * 1000);
  const beginS = (add: number): number => new Date(day.getFullYear(), day.getMonth(), day.getDate() + add, 0, minutes).getTime() / 1000;
  return shiftAt(begins, beginS(0) <= nowS.peek() ? beginS(0) : beginS(-1));
}

function Own({ shift }: { shift: Shift }) {
  const own = useSignal({ from: "", until: "" });
  const local = (atS: number): string => {
    const at = new Date(atS * 1000);
    return new Date(at.getTime() - at.getTimezoneOffset() * 60_000).toISOString().slice(0, 16);
  };
  const change = (which: "from" | "until", text: string): void => {
    own.value = { from: local(shift.fromS), until: local(shift.untilS), ...own.value.from === "" ? {} : own.value, [which]: text };
    const fromS = new Date(own.value.from).getTime() / 1000;
    const untilS = new Date(own.value.until).getTime() / 1000;
    if (fromS < untilS) show({ name: "", fromS, untilS });
  };
  return (
    <span class="shift-own">
      {(["from", "until"] as const).map((which) => (
        <label key={which}>
          {t(`shift.${which}`)}{" "}
          <input type="datetime-local" value={local(which === "from" ? shift.fromS : shift.untilS)} onChange={(event) => { change(which, event.currentTarget.value); }} />
        </label>
      ))}
    </span>
  );
}

function Paper({ report, shift }: Answer) {
  return (
    <article class="shift-paper">
      <Head report={report} shift={shift} />
      <KeptNote kind="figures" fromS={shift.fromS} />
      <section>
        <h2>{t("shift.figures")}</h2>
        <div class="shift-scroll" tabIndex={0} role="group" aria-label={t("shift.figures")}>
          <FiguresTable report={report} />
        </div>
      </section>
      <Use report={report} />
      <section class="shift-defined">
        <h2>{t("shift.defined")}</h2>
        <ol>
          {Object.values(GROUPS).flat().map((name) => (
            <li key={name}>
              <b>{word("shift.f", name)}:</b> {word("shift.def", name)}
            </li>
          ))}
        </ol>
        <p>{t("shift.near")}</p>
      </section>
      <div class="shift-lists">
        <Happened report={report} />
        <DrillDown report={report} />
      </div>
    </article>
  );
}
