import { fetchDuty } from "../../../api/client";
import type { ColleagueView } from "../../../api/types";
import { presentS } from "../../../stream/stream";
import { speakAlso } from "../../../text/speech";
import { format, t, tables, word } from "../../../text/views/duty";
import { useRefreshed } from "../../refreshed";
import { plant } from "../../state";

/** People say every 5 s that they are there. */
const ASK_MS = 5000;

/** The row, once it has its words. */
export async function load(): Promise<typeof DutyRow> {
  await speakAlso(tables);
  return DutyRow;
}

/** Who is on duty, and in which areas nobody is. */
export function DutyRow() {
  const view = useRefreshed(fetchDuty, ASK_MS).answer.value;
  if (view === null) return null;
  const { areas_without: without, colleagues, comes_at_s: comesS } = view;
  const told = without.length > 0 && (colleagues.length > 0 || Object.keys(comesS).length > 0);
  return (
    <div class="status-row duty-row">
      <span>{t("duty.title")}</span>
      {colleagues.length === 0 ? (
        <span>{t("duty.nobodyAtAll")}</span>
      ) : (
        <details>
          <summary>{t("duty.count", { count: format.count(colleagues.length) })}</summary>
          <ul>
            {colleagues.map((each) => (
              <li key={each.code}>{personText(each)}</li>
            ))}
          </ul>
        </details>
      )}
      {told && <p class="tone-warn">{t("duty.nobodyIn", { areas: format.list(without.map((area) => areaUntil(area, comesS[area]))) })}</p>}
    </div>
  );
}

function personText({ areas, busy_with: caller, code, label, station, status, until_at_s: untilS }: ColleagueView): string {
  const said = [
    label === "" ? code : label,
    station,
    format.list(areas.map(areaName)),
    caller === "" ? word("duty.status", status) : t("duty.busyWith", { caller }),
    untilS === null ? "" : t("duty.until", { at: format.due(untilS, presentS.value) }),
  ];
  return said.filter((each) => each !== "").join(" · ");
}

/** An area in which nobody is, and until when by its working time. */
function areaUntil(area: string, comesS: number | undefined): string {
  const name = areaName(area);
  return comesS === undefined ? name : t("duty.nobodyUntil", { area: name, at: format.due(comesS, presentS.value) });
}

function areaName(id: string): string {
  return plant.value?.areas.find((area) => area.id === id)?.name ?? id;
}
