/** An alert in words. */
import type { AlertView } from "../api/types";
import { THING } from "../plant/names";
import { format, t } from "../text";
import { vehicleName } from "../text/elsewhere";
import { causeText } from "../text/failure";
import { jamText } from "../text/wait";
import { factoryTime } from "../text/plant-time";

/** @param speed factory seconds per real second */
export function whatText(alert: AlertView, nowS: number, speed: number): string {
  const { agents, call, cause, goods } = alert;
  let said = kindText(alert, nowS, speed);
  if (cause !== null) said += `: ${cause.wait !== null && agents.length > 0 ? jamText(agents, cause.wait) : causeText(cause)}`;
  if (goods !== null) said += `; ${t(goods.item === THING ? "alerts.what.thing_kept" : "alerts.what.goods_kept", { at: format.due(alert.until_at_s ?? nowS, nowS) })}`;
  return call === null ? said : `${said}; ${t(`alerts.call.${call}`)}`;
}

export function asksText(alert: AlertView): string {
  return t(`alerts.asks.${alert.response}`);
}

function kindText(alert: AlertView, nowS: number, speed: number): string {
  const { battery_frac, by, clock_ahead_s, doubt, goods, kind, seen_at_s, until_at_s } = alert;
  const leftS = ((until_at_s ?? nowS) - nowS) * speed;
  switch (kind) {
    case "plant_behind":
      return t("alerts.what.plant_behind", { age: format.age(alert.behind_s ?? 0) });
    case "overloaded":
      return overloadText(alert);
    case "machine_lost":
    case "atv_lost":
      return t("alerts.what.lost", { age: format.age(nowS - (seen_at_s ?? nowS)) });
    case "part_lost":
      return t("alerts.what.part_lost", { age: format.age(nowS - (seen_at_s ?? nowS)), agents: format.list(alert.agents.map(vehicleName)) });
    case "atv_awaited":
      return t("alerts.what.atv_awaited", { keepers: format.list(alert.keepers) });
    case "atv_unplaced":
      return t("alerts.what.atv_unplaced", { age: format.age(nowS - (seen_at_s ?? nowS)) });
    case "atv_unheard":
      return t("alerts.what.atv_unheard", { agents: format.list(alert.agents.map(vehicleName)) });
    case "station_lost":
      return t("alerts.what.station_lost", { age: format.age(nowS - (seen_at_s ?? nowS)) });
    case "gate_lost":
      return t("alerts.what.gate_lost", { age: format.age(nowS - (seen_at_s ?? nowS)) });
    case "dock_not_ready":
      return t("alerts.what.dock_not_ready", { age: format.age(nowS - (seen_at_s ?? nowS)), agents: format.list(alert.agents.map(vehicleName)) });
    case "strategist_lost":
      return t("alerts.what.strategist_lost", { agents: format.list(alert.agents.map(vehicleName)) });
    case "atv_help":
      return leftS > 0 ? t("alerts.what.atv_help", { left: factoryTime(leftS, speed) }) : t("alerts.what.help_late");
    case "atv_promised":
      return t("alerts.what.atv_promised", { by, left: factoryTime(Math.max(0, leftS), speed) });
    case "machine_shut_out":
    case "station_shut_out":
    case "atv_shut_out":
      return t("alerts.what.shut_out", { by });
    case "clock_wrong": {
      const aheadS = clock_ahead_s ?? 0;
      return t(aheadS < 0 ? "alerts.what.clock_behind" : "alerts.what.clock_ahead", { by: factoryTime(Math.abs(aheadS), speed) });
    }
    case "atv_battery":
      return t("alerts.what.atv_battery", { percent: format.percent(battery_frac ?? 0) });
    case "access_point":
      return t("alerts.what.access_point", {
        point: alert.access_point,
        age: format.age(nowS - (seen_at_s ?? nowS)),
        atvs: format.list(alert.agents.map(vehicleName)),
      });
    case "atv_mesh":
      return meshText(alert, nowS);
    case "goods_stranded":
      if (goods?.item === THING) {
        const { machine: place, handed_at: node } = goods;
        return t(node ? "alerts.what.thing_handed" : "alerts.what.thing_stranded", { place, node });
      }
      return t(goods?.handed_at ? "alerts.what.goods_handed" : "alerts.what.goods_stranded", {
        quantity: format.count(goods?.quantity ?? 0),
        item: goods?.name ?? "",
        order: goods === null || goods.order_name === "" ? "–" : goods.order_name,
        node: goods?.handed_at ?? "",
      });
    // It is told of a transport: whose dock that is must be said.
    case "dock_fails":
      return t("alerts.what.dock_fails", { place: alert.agent });
    case "load_doubtful":
      return t(doubt?.brought === true ? "alerts.what.load_doubtfulBrought" : "alerts.what.load_doubtful", {
        quantity: format.count(doubt?.quantity ?? 0),
        item: doubt?.name ?? "",
        atv: vehicleName(doubt?.vehicle ?? ""),
      });
    case "order_late":
      return t("alerts.what.order_late", { due: format.due(until_at_s ?? nowS, nowS) });
    default:
      return t(`alerts.what.${kind}`);
  }
}

/** Since when, by which access point before, and over whom it is heard: as much of it as is known. */
function meshText({ access_point: point, agents, seen_at_s: sinceS }: AlertView, nowS: number): string {
  const said = [t("alerts.what.atv_mesh")];
  if (sinceS !== null) said.push(t("alerts.what.atv_meshSince", { age: format.age(nowS - sinceS) }));
  if (point !== "") said.push(t("alerts.what.atv_meshAt", { point }));
  if (agents.length > 0) said.push(t("alerts.what.atv_meshOver", { atvs: format.list(agents.map(vehicleName)) }));
  return said.join(", ");
}

function overloadText({ carried_frac, waiting }: AlertView): string {
  const said = { waiting: String(waiting ?? 0) };
  if (carried_frac === null) return t("alerts.what.overloaded", said);
  return t("alerts.what.overloadedCarried", { ...said, percent: format.percent(carried_frac) });
}
