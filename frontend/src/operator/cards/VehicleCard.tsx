import type { AtvView } from "../../api/types";
import { batteryText } from "../../parts/battery";
import { BodyWait } from "../../parts/BodyWait";
import { Carrying } from "../../parts/Carrying";
import { Link } from "../../parts/Link";
import { Meter } from "../../parts/Meter";
import { Tag } from "../../parts/Tag";
import { selection } from "../../selection/selection";
import { world } from "../../stream/stream";
import { format, t, word } from "../../text/operator";
import { factoryTime } from "../../text/plant-time";
import { placeOf } from "../../text/place";
import { waitText } from "../../text/wait";
import { areaAt, distanceM } from "../area/region";
import { CommandLine } from "../commands/CommandLine";
import { problemText } from "../problem-text";
import { moment, names, plant, station } from "../state";
import { forms } from "./forms";
import { HelpAsk } from "./HelpAsk";
import { type Need, needOf } from "./need";
import { Release } from "./Release";
import { Service } from "./Service";
import { isSettling } from "./settling";
import { SpeedSteps } from "./SpeedSteps";

const TONES = {
  help: "warn", coming: "warn", problem: "alarm", lost: "alarm", stopped: "warn", out: "normal", working: "normal", resting: "normal",
} as const;


/** One vehicle near: what it does or needs, and what a person may ask of it. Stop is in the bar below all cards. */
export function VehicleCard({ atv, left, tooSoon }: { atv: AtvView; left: boolean; tooSoon: boolean }) {
  const need = needOf(atv, moment.value);
  const chosen = selection.value.atv === atv.id;
  return (
    <li class={["vehicle card", `need-${need}`, chosen && "chosen", left && "left", isSettling(atv.id) && "settling"].filter(Boolean).join(" ")} id={`vehicle-${atv.id}`}>
      <div class="vehicle-body">
        <header>
          <h2>
            <Link kind="atv" id={atv.id} />
          </h2>
          <Tag tone={left ? "normal" : TONES[need]}>{left ? t("need.left") : needText(atv, need)}</Tag>
          {tooSoon && <Tag tone="warn">{t("stop.tooSoon")}</Tag>}
          {need === "stopped" && atv.problem !== "" && <Tag tone="alarm">{t("need.problem")}</Tag>}
          {need === "lost" && atv.status === "stopped" && <Tag tone="warn">{t("need.stopped")}</Tag>}
          <Where atv={atv} />
        </header>
        <div class="vehicle-now" inert={left}>
          {!atv.removal && <p class="doing">{need === "lost" ? lostText(atv) : taskText(atv)}</p>}
          {need !== "lost" && <Waits atv={atv.id} />}
          {need !== "lost" && <BodyWait atv={atv} {...moment.value} />}
          <Carrying atv={atv} atvs={world.value?.atvs.values() ?? []} isSimulated={world.value?.fault_injection ?? false} plant={plant.value} {...moment.value} problemText={problemText} />
          {(atv.help !== null || atv.problem !== "") && need !== "lost" && <HelpAsk atv={atv} />}
        </div>
        <div class="vehicle-acts">
          <div class="as-one" inert={left}>
            {atv.status === "stopped" && <Release atv={atv} />}
            {atv.status !== "stopped" && atv.problem !== "" && <p class="advice">{t("release.stopFirst")}</p>}
            <SpeedSteps atv={atv} />
          </div>
          <Service atv={atv} left={left} />
          {left && forms.value.has(atv.id) && <p class="advice">{t("service.gone")}</p>}
        </div>
        <CommandLine atv={atv.id} stopped={atv.status === "stopped"} />
      </div>
    </li>
  );
}

function needText(atv: AtvView, need: Need): string {
  if (need === "working") return word("phase", atv.task?.phase ?? "working");
  return need === "resting" ? word("atv", atv.status) : t(`need.${need}`);
}

function lostText(atv: AtvView): string {
  if (atv.shut_out) return t("card.shutOut", { by: atv.shut_out.by, reason: atv.shut_out.reason });
  return t("card.lost", { age: format.age(moment.value.nowS - atv.seen_at_s) });
}

/** For whom it waits on its way, and for how long. */
function Waits({ atv }: { atv: string }) {
  const wait = world.value?.waits.get(atv);
  if (!wait) return null;
  const { nowS, speed } = moment.value;
  const age = factoryTime(Math.max(0, nowS - wait.since_at_s) * speed);
  return (
    <p class="waits">
      {t("wait.says", { atv, what: waitText(wait.cause) })} · <span class="num">{age}</span>
    </p>
  );
}

/** Where it is, and how its battery is. */
function Where({ atv }: { atv: AtvView }) {
  const from = station.value;
  const areas = plant.value?.areas ?? [];
  const area = areas.length > 1 ? areaAt(areas, atv.x_m, atv.y_m) : undefined;
  const percent = batteryText(atv);
  return (
    <span class="where">
      {area && <span>{t("card.in", { area: area.name })}</span>}
      {from && <span class="num">{t("card.away", { metres: format.count(distanceM(from, atv)) })}</span>}
      {atv.link === "mesh" && <span class="tone-warn">{t("card.mesh")}</span>}
      <span class="battery">
        <Meter frac={atv.battery_frac} label={t("card.battery", { percent })} tone={atv.battery_low ? "warn" : "normal"} />
        <span class="num" aria-hidden="true">{percent}</span>
      </span>
    </span>
  );
}

function taskText(atv: AtvView): string {
  const { load, load_quantity: loaded, task } = atv;
  const pieces = (item: string, count: number) => ({ quantity: format.count(count), item: names.value(item) });
  if (!task) return load === "" ? t("card.noTask") : t("card.loaded", pieces(load, loaded));
  const told = world.value?.tasks.get(task.task)?.destination ?? "";
  const destination = told === "" ? task.coordinator : told;
  const what = pieces(task.item, task.quantity);
  if (task.phase === "returning") return t("card.bringing", what);
  const there = task.due_at_s === null ? "" : ` · ${t("card.there", { at: format.due(task.due_at_s, moment.value.nowS) })}`;
  const going = load === "" ? "card.fetching" : "card.going";
  return t(going, { ...what, destination: placeOf(destination) }) + there;
}
