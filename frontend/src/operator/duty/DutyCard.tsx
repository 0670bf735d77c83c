import type { CallView, ColleagueView } from "../../api/types";
import { format, t, word } from "../../text/operator";
import { plant } from "../state";
import { be, duty, dutyFailed, type DutyState } from "./duty";

const CHOICES: readonly DutyState[] = ["on", "break", "off"];

/** Whether this person is on duty, who else is, and who comes to whom. */
export function DutyCard() {
  const view = duty.value;
  if (view === null) return null;
  const away = view.areas_without.map(areaName);
  const calls = view.calls.filter(({ part }) => part === null);
  return (
    <section class="card duty" aria-label={t("duty.title")}>
      <h2>{t("duty.title")}</h2>
      <div class="duty-choices" role="group" aria-label={t("duty.mine")}>
        {CHOICES.map((state) => (
          <button key={state} type="button" class="button" aria-pressed={view.state === state} onClick={() => void be(state)}>
            {t(`duty.${state}`)}
          </button>
        ))}
      </div>
      {dutyFailed.value !== "" && (
        <p class="problem" role="alert">
          {dutyFailed.value}
        </p>
      )}
      {view.state !== "off" && (
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
          {calls.map((call) => (
            <Call key={call.id} call={call} />
          ))}
        </ul>
      )}
      {view.state !== "off" && away.length > 0 && <p class="duty-nobody">{t("duty.nobody", { areas: format.list(away) })}</p>}
      <p class="muted">{t("duty.known")}</p>
    </section>
  );
}

function Colleague({ colleague: { areas, busy_with: caller, code, label, station, status } }: { colleague: ColleagueView }) {
  return (
    <li>
      <span>
        {label === "" ? code : label}
        {station !== "" && ` · ${station}`} <span class="muted">{format.list(areas.map(areaName))}</span>
      </span>
      <span>{caller === "" ? word("duty.status", status) : t("duty.busyWith", { caller })}</span>
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

function areaName(id: string): string {
  return plant.value?.areas.find((area) => area.id === id)?.name ?? id;
}
