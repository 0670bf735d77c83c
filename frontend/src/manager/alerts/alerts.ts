/** What on the plant is not as it should be, worst first. Pure. */
import type { AtvView, MachineView, OrderView, TaskView } from "../../api/types";
import type { Chosen } from "../../selection/selection";
import { isLost } from "../../plant/silence";
import { helpLeftS } from "../atv/help";
import type { World } from "../../stream/world";

export type AlertReason =
  | "machineError" | "machineStarved" | "machineBlocked" | "machineLost"
  | "atvError" | "atvStopped" | "atvLost" | "atvBattery" | "atvHelp" | "atvPromised"
  | "taskTrouble" | "orderLate" | "orderWaits";

export interface Alert {
  readonly level: "alarm" | "warning";
  readonly reason: AlertReason;
  /** Whom it is about, in people's words. */
  readonly subject: string;
  /** In the agent's own words, where it has any. */
  readonly problem: string;
  /** A number for the text: an age, what is left of a time or a due time in seconds, or a fraction. */
  readonly value: number;
  /** A person for the text: who is on the way. */
  readonly by?: string;
  /** What to show for it; null for an order. */
  readonly chosen: Chosen | null;
}

/** A vehicle goes to a charger long before; at this level something keeps it from there. */
const BATTERY_FRAC = 0.1;

export function alertsOf(world: World, nowS: number): Alert[] {
  const speed = world.factory.speed;
  const alerts = [
    ...[...world.machines.values()].flatMap((machine) => machineAlert(machine, nowS, speed)),
    ...[...world.atvs.values()].flatMap((atv) => atvAlert(atv, nowS, speed)),
    ...[...world.tasks.values()].flatMap((task) => taskAlert(task, world)),
    ...[...world.orders.values()].flatMap((order) => orderAlert(order, nowS)),
  ];
  return alerts.sort((a, b) => Number(b.level === "alarm") - Number(a.level === "alarm"));
}

function machineAlert(machine: MachineView, nowS: number, speed: number): Alert[] {
  const { id, problem, status } = machine;
  const chosen: Chosen = { kind: "machine", id };
  const base = { subject: id, problem, value: 0, chosen };
  if (isLost(machine, nowS, speed)) {
    return [{ ...base, problem: "", level: "alarm", reason: "machineLost", value: nowS - machine.seen_at_s }];
  }
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
  if (atv.help) {
    const { promised_by: by } = atv.help;
    const value = helpLeftS(atv.help, nowS, speed);
    // Who is on the way has answered: there is nothing more to ask for.
    if (by !== "") return [{ ...base, level: "warning", reason: "atvPromised", value, by }];
    return [{ ...base, level: "alarm", reason: "atvHelp", value }];
  }
  if (atv.status === "error") return [{ ...base, level: "alarm", reason: "atvError" }];
  if (atv.status === "stopped") return [{ ...base, level: "warning", reason: "atvStopped" }];
  if (atv.battery_frac < BATTERY_FRAC && atv.status !== "charging") {
    return [{ ...base, level: "warning", reason: "atvBattery", value: atv.battery_frac }];
  }
  return [];
}

/** Unless its carrier tells of it already; of a goal's trouble its order tells. */
function taskAlert({ id, kind, primary, trouble }: TaskView, world: World): Alert[] {
  if (trouble === "" || kind === "production" || trouble === world.atvs.get(primary)?.problem) return [];
  const chosen: Chosen = { kind: "task", id };
  return [{ level: "warning", reason: "taskTrouble", subject: id, problem: trouble, value: 0, chosen }];
}

function orderAlert(order: OrderView, nowS: number): Alert[] {
  const subject = order.reference ?? order.id;
  if (order.waits !== "") {
    return [{ level: "warning", reason: "orderWaits", subject, problem: order.waits, value: 0, chosen: null }];
  }
  if (!isLate(order, nowS)) return [];
  const value = order.due_at_s ?? 0;
  return [{ level: "warning", reason: "orderLate", subject, problem: "", value, chosen: null }];
}

/** Due and not delivered. */
export function isLate(order: OrderView, nowS: number): boolean {
  if (order.due_at_s === null || order.status === "cancelled") return false;
  return (order.delivered_at_s ?? nowS) > order.due_at_s;
}
