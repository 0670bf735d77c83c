/** What on the plant is not as it should be, worst first. Pure. */
import type { AtvView, MachineView, OrderView } from "../../api/types";
import type { Chosen } from "../../selection/selection";
import { isLost } from "../../plant/silence";
import type { World } from "../../stream/world";

export type AlertReason =
  | "machineError" | "machineStarved" | "machineBlocked"
  | "atvError" | "atvStopped" | "atvLost" | "atvBattery"
  | "orderLate";

export interface Alert {
  readonly level: "alarm" | "warning";
  readonly reason: AlertReason;
  /** Whom it is about, in people's words. */
  readonly subject: string;
  /** In the agent's own words, where it has any. */
  readonly problem: string;
  /** A number for the text: an age or a due time in seconds, or a fraction. */
  readonly value: number;
  /** What to show for it; null for an order. */
  readonly chosen: Chosen | null;
}

/** A vehicle goes to a charger long before; at this level something keeps it from there. */
const BATTERY_FRAC = 0.1;

export function alertsOf(world: World, nowS: number): Alert[] {
  const speed = world.factory.speed;
  const alerts = [
    ...[...world.machines.values()].flatMap(machineAlert),
    ...[...world.atvs.values()].flatMap((atv) => atvAlert(atv, nowS, speed)),
    ...[...world.orders.values()].flatMap((order) => orderAlert(order, nowS)),
  ];
  return alerts.sort((a, b) => Number(b.level === "alarm") - Number(a.level === "alarm"));
}

function machineAlert(machine: MachineView): Alert[] {
  const { id, problem, status } = machine;
  const chosen: Chosen = { kind: "machine", id };
  const base = { subject: id, problem, value: 0, chosen };
  if (status === "error") return [{ ...base, level: "alarm", reason: "machineError" }];
  if (status === "starved") return [{ ...base, level: "warning", reason: "machineStarved" }];
  if (status === "blocked") return [{ ...base, level: "warning", reason: "machineBlocked" }];
  return [];
}

function atvAlert(atv: AtvView, nowS: number, speed: number): Alert[] {
  const chosen: Chosen = { kind: "atv", id: atv.id };
  const base = { subject: atv.id, problem: atv.problem, value: 0, chosen };
  if (isLost(atv, nowS, speed)) {
    return [{ ...base, level: "alarm", reason: "atvLost", value: nowS - atv.seen_at_s }];
  }
  if (atv.status === "error") return [{ ...base, level: "alarm", reason: "atvError" }];
  if (atv.status === "stopped") return [{ ...base, level: "warning", reason: "atvStopped" }];
  if (atv.battery_frac < BATTERY_FRAC && atv.status !== "charging") {
    return [{ ...base, level: "warning", reason: "atvBattery", value: atv.battery_frac }];
  }
  return [];
}

function orderAlert(order: OrderView, nowS: number): Alert[] {
  if (!isLate(order, nowS)) return [];
  const subject = order.reference ?? order.id;
  const value = order.due_at_s ?? 0;
  return [{ level: "warning", reason: "orderLate", subject, problem: "", value, chosen: null }];
}

/** Due and not delivered. */
export function isLate(order: OrderView, nowS: number): boolean {
  if (order.due_at_s === null || order.status === "cancelled") return false;
  return (order.delivered_at_s ?? nowS) > order.due_at_s;
}
