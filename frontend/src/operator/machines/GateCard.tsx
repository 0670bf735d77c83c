import type { StationView } from "../../api/types";
import { Tag } from "../../parts/Tag";
import { GATE } from "../../plant/places";
import { isLost } from "../../plant/silence";
import { world } from "../../stream/stream";
import { failureText } from "../../text/failure";
import { t } from "../../text/operator";
import type { Moment } from "../cards/need";
import { moment } from "../state";

/** The delivery gate of the area, while its controller has a problem; a silent gate tells nothing. */
export function needingGate(stations: ReadonlyMap<string, StationView> | undefined, { nowS, speed }: Moment): StationView | null {
  const gate = stations?.get(GATE);
  return gate && gate.problem !== "" && !isLost(gate, nowS, speed) ? gate : null;
}

/** Why the gate does not count, or lets no container in: whoever is near sees to it. */
export function GateCard() {
  const gate = needingGate(world.value?.stations, moment.value);
  if (gate === null) return null;
  return (
    <ul class="cards needing" aria-label={t("gate.title")}>
      <li class="vehicle card machine-need need-help" id="gate-problem">
        <div class="vehicle-body">
          <header>
            <h2>{t("gate.title")}</h2>
            <Tag tone="warn">{t("machine.need.help")}</Tag>
          </header>
          <div class="vehicle-now">
            <p class="help-what">{t("help.what", { problem: failureText(gate.problem) })}</p>
            <p class="doing">{t("gate.waits")}</p>
          </div>
        </div>
      </li>
    </ul>
  );
}
