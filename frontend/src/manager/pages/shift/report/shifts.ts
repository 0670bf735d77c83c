/** Which shifts there are, and how a figure of one is read. Pure. */
import type { components } from "../../../../api/types";

export type Report = components["schemas"]["ShiftReport"];
export type Figure = components["schemas"]["ReportFigure"];
export type Agent = components["schemas"]["AgentShift"];
export type Targets = components["schemas"]["TargetsView"];
export type Against = "day" | "before" | "week";

export interface Shift {
  /** As the settings name it; empty for a time of somebody's own. */
  readonly name: string;
  readonly fromS: number;
  readonly untilS: number;
}

type Begins = readonly components["schemas"]["ShiftBegin"][];

/** Midnight comes by the clock of whoever looks, and so do days of 23 and 25 hours. */
function momentOf(day: Date, addDays: number, minutes: number): number {
  return new Date(day.getFullYear(), day.getMonth(), day.getDate() + addDays, 0, minutes).getTime() / 1000;
}

/** All shifts of the day before a moment, of its day and of the day after, the earliest first. */
export function shiftsAround(begins: Begins, atS: number): Shift[] {
  const day = new Date(atS * 1000);
  const all = [-2, -1, 0, 1, 2].flatMap((add) => begins.map(({ begin_min, name }) => ({ name, fromS: momentOf(day, add, begin_min) })));
  return all.slice(0, -1).map((each, i) => ({ ...each, untilS: all[i + 1]?.fromS ?? each.fromS }));
}

export function shiftAt(begins: Begins, atS: number): Shift {
  const found = shiftsAround(begins, atS).find((each) => each.fromS <= atS && atS < each.untilS);
  return found ?? { name: "", fromS: atS - 8 * 3600, untilS: atS };
}

/** The shift of an address; where that is none of the plant's it has no name. */
export function shiftOf(begins: Begins, from: string | undefined, until: string | undefined, nowS: number): Shift {
  const fromS = Date.parse(from ?? "") / 1000;
  const untilS = Date.parse(until ?? "") / 1000;
  if (!Number.isFinite(fromS) || !Number.isFinite(untilS)) return shiftAt(begins, nowS);
  const own = { name: "", fromS, untilS };
  const near = shiftAt(begins, fromS);
  return near.fromS === fromS && near.untilS === untilS ? near : own;
}

export function neighbour(begins: Begins, shift: Shift, step: -1 | 1): Shift {
  const lengthS = shift.untilS - shift.fromS;
  if (shift.name === "") return { name: "", fromS: shift.fromS + step * lengthS, untilS: shift.untilS + step * lengthS };
  return shiftAt(begins, step < 0 ? shift.fromS - 1 : shift.untilS);
}

export const GROUPS = {
  orders: ["orders_delivered", "on_time_frac", "orders_late", "orders_open", "orders_overdue"],
  transports: ["transports", "transport_p50_s", "transport_p95_s", "empty_frac"],
  machines: ["starved_frac", "machine_producing_frac", "machine_available_frac"],
  vehicles: ["atv_available_frac", "waits", "waited_frac", "energy_wh", "transport_energy_wh"],
  people: ["interventions", "helps", "takeovers"],
} as const;

/** What of a figure the course has, half hour by half hour. */
export const COURSES = ["orders_delivered", "on_time_frac", "transports", "empty_frac", "starved_frac", "machine_available_frac", "atv_available_frac", "energy_wh", "helps"] as const;

export function courseOf(report: Report, name: string): number[] {
  const known = COURSES.find((each) => each === name);
  return known === undefined ? [] : report.course.map((point) => point[known]).filter((value) => value !== null);
}

/** Parts of the width of a bar: the value, and where its target stands; null where there is nothing to set it against. */
export function barOf({ before, target, value }: Figure): { value: number; target: number | null } | null {
  const most = Math.max(value ?? 0, target ?? 0, before ?? 0) * 1.1;
  if (most <= 0 || value === null || (target === null && before === null)) return null;
  return { value: value / most, target: target === null ? null : target / most };
}

const STATES = {
  productive: ["makes", "fetches", "carries"],
  standby: ["idle", "starves", "waits"],
  scheduled: ["out", "charges"],
  unscheduled: ["broken", "silent", "stopped"],
} as const;
export type State = keyof typeof STATES;
export const STATE_NAMES = Object.keys(STATES) as State[];

/** The state of SEMI E10 of what an agent does: a machine that nobody takes from stands by, a vehicle in error is down. */
export function stateOf(kind: string, doing: string): State {
  if (doing === "blocked") return kind === "machine" ? "standby" : "unscheduled";
  return STATE_NAMES.find((state) => (STATES[state] as readonly string[]).includes(doing)) ?? "standby";
}

/**
 * Parts of an agent's time by state; together they are 1, or 0 where nothing is known. What a machine rests by its working time is not
 * divided: non-scheduled time.
 */
export function statesOf({ doings_s, kind }: Agent): Record<State, number> {
  const found: Record<State, number> = { productive: 0, standby: 0, scheduled: 0, unscheduled: 0 };
  const doings = Object.entries(doings_s).filter(([doing]) => doing !== "rests");
  const allS = doings.reduce((sum, [, spentS]) => sum + spentS, 0);
  for (const [doing, spentS] of doings) found[stateOf(kind, doing)] += allS > 0 ? spentS / allS : 0;
  return found;
}
