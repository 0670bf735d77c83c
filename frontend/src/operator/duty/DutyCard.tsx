import { useSignal } from "@preact/signals";
import { soundChosen, wantSound } from "../../alerts/sound";
import type { CallView, ColleagueView, DutyView } from "../../api/types";
import { format, t, word } from "../../text/operator";
import { inFactoryTime } from "../../text/plant-time";
import { moment, plant } from "../state";
import { be, duty, dutyFailed, type DutyState } from "./duty";

const CHOICES: readonly DutyState[] = ["on", "break", "off"];

const BUSY_MINUTES = [10, 30, 60];

type Kind = DutyView["helps_with"][number];

const KINDS: readonly Kind[] = [
  "load", "drive", "sensor", "battery", "way_blocked", "lost_position", "link", "emergency_stop", "dock", "tool", "jam", "software", "unknown",
];

/** Whether this person is on duty, in a line; who else is, and who comes to whom, where somebody wants to know. */
export function DutyCard() {
  const opened = useSignal(false);
  const view = duty.value;
  if (view === null) return null;
  const away = view.areas_without.map((area) => areaUntil(area, view.comes_at_s[area]));
  const calls = view.calls.filter(({ part }) => part === null);
  return (
    <section id="duty" class="card duty" aria-label={t("duty.title")}>
      <div class="duty-line">
        <h2>{t("duty.title")}</h2>
        <div class="duty-choices" role="group" aria-label={t("duty.mine")}>
          {CHOICES.map((state) => (
            <button key={state} type="button" class="button" aria-pressed={view.state === state} onClick={() => void be(state)}>
              {t(`duty.${state}`)}
            </button>
          ))}
        </div>
        <button
          type="button"
          class="button"
          aria-expanded={opened.value}
          aria-controls="duty-more"
          disabled={view.state === "off"}
          onClick={() => (opened.value = !opened.value)}
        >
          {t("duty.more", { count: format.count(view.colleagues.length) })}
        </button>
      </div>
      {view.state !== "off" && <AskForSound />}
      {dutyFailed.value !== "" && (
        <p class="problem" role="alert">
          {dutyFailed.value}
        </p>
      )}
      {view.state !== "off" && away.length > 0 && <p class="duty-nobody">{t("duty.nobody", { areas: format.list(away) })}</p>}
      {view.state === "on" && view.busy_until_at_s !== null && <p>{busyText(view.busy_until_at_s)}</p>}
      {view.state !== "off" && calls.length > 0 && (
        <ul class="duty-list">
          {calls.map((call) => (
            <Call key={call.id} call={call} />
          ))}
        </ul>
      )}
      <div id="duty-more" hidden={!opened.value || view.state === "off"}>
        <More view={view} />
      </div>
    </section>
  );
}

function More({ view }: { view: DutyView }) {
  return (
    <>
      {view.state === "on" && <Busy view={view} />}
      <WhatFor view={view} />
      <ul class="duty-list">
        {view.code !== "" && (
          <li>
            <b>{t("duty.you")}</b>
            <span>{t("duty.code", { code: view.code })}</span>
          </li>
        )}
        {view.colleagues.map((each) => (
          <Colleague key={each.code} colleague={each} />
        ))}
      </ul>
      <p class="muted">{t("duty.known")}</p>
    </>
  );
}

/** Asked for once. What was chosen is kept in this browser, and changed in the settings. */
function AskForSound() {
  if (soundChosen.value) return null;
  return (
    <div class="duty-sound" role="group" aria-label={t("duty.sound")}>
      <span>{t("duty.sound")}</span>
      <button type="button" class="button primary" onClick={() => void wantSound(true)}>
        {t("duty.soundYes")}
      </button>
      <button type="button" class="button" onClick={() => void wantSound(false)}>
        {t("duty.soundNo")}
      </button>
    </div>
  );
}

function busyText(untilS: number): string {
  return t("duty.busyUntil", { at: format.due(untilS, moment.value.nowS) });
}

/** By one's own word: asked only when nobody else is left. Going on duty once more ends it. */
function Busy({ view }: { view: DutyView }) {
  return (
    <div class="duty-busy" role="group" aria-label={inFactoryTime(t("duty.busyFor"))}>
      <span>{view.busy_until_at_s === null ? inFactoryTime(t("duty.busyFor")) : busyText(view.busy_until_at_s)}</span>
      {BUSY_MINUTES.map((minutes) => (
        <button key={minutes} type="button" class="button" onClick={() => void be("on", { busy_for_s: minutes * 60 })}>
          {t("duty.busyMinutes", { minutes })}
        </button>
      ))}
    </div>
  );
}

/** For which kinds of problems somebody is there. */
function WhatFor({ view: { helps_with: chosen, state } }: { view: DutyView }) {
  const said = chosen.length === 0 ? t("duty.everything") : format.list(chosen.map((kind) => t(`duty.for.${kind}`)));
  const turned = (kind: Kind) => (chosen.includes(kind) ? chosen.filter((each) => each !== kind) : [...chosen, kind]);
  return (
    <details class="duty-for">
      <summary>{t("duty.whatFor", { what: said })}</summary>
      <p class="muted">{t("duty.whatForMore")}</p>
      <div class="duty-choices">
        {KINDS.map((kind) => (
          <button
            key={kind}
            type="button"
            class="button"
            aria-pressed={chosen.includes(kind)}
            onClick={() => void be(state, { helps_with: turned(kind) })}
          >
            {t(`duty.for.${kind}`)}
          </button>
        ))}
      </div>
    </details>
  );
}

function Colleague({ colleague: { areas, busy_with: caller, code, helps_with: kinds, label, station, status, until_at_s: untilS } }: { colleague: ColleagueView }) {
  return (
    <li>
      <span>
        {label === "" ? code : label}
        {station !== "" && ` · ${station}`} <span class="muted">{format.list(areas.map(areaName))}</span>
        {kinds.length > 0 && <span class="muted"> · {format.list(kinds.map((kind) => t(`duty.for.${kind}`)))}</span>}
      </span>
      <span>
        {caller === "" ? word("duty.status", status) : t("duty.busyWith", { caller })}
        {untilS !== null && ` · ${t("duty.until", { at: format.due(untilS, moment.value.nowS) })}`}
      </span>
    </li>
  );
}

function Call({ call }: { call: CallView }) {
  const by = call.taken_by;
  const said = by !== "" ? t("duty.comes", { by }) : call.on_duty === 0 ? t("duty.nobodyThere") : t("duty.asking");
  return (
    <li class={by === "" ? "duty-open" : ""}>
      <span>{t("duty.calls", { caller: call.caller })}</span>
      <span>{said}</span>
    </li>
  );
}

/** An area in which nobody is, and until when by its working time. */
function areaUntil(area: string, comesS: number | undefined): string {
  const name = areaName(area);
  return comesS === undefined ? name : t("duty.nobodyUntil", { area: name, at: format.due(comesS, moment.value.nowS) });
}

function areaName(id: string): string {
  return plant.value?.areas.find((area) => area.id === id)?.name ?? id;
}
