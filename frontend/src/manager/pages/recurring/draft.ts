/** Recurring work as somebody writes it: days and a time, or cron's own fields. */
import type { Schedule, ScheduleDraft } from "../../../api/schedules";
import { isPriority, type Priority } from "../../orders/priority";
import { DAYS, type Rhythm, rhythmOf } from "./rhythm";

/** A line of an order. */
export interface Line {
  readonly product: string;
  readonly quantity: string;
}

export const NO_LINE: Line = { product: "", quantity: "" };

export interface Written {
  readonly name: string;
  /** What recurs: something is brought, or an order is placed. */
  readonly kind: "transport" | "order";
  readonly days: readonly string[];
  readonly time: string;
  /** The calendar of which days and time were read; it is sent as it is while they say the same. Empty for none. */
  readonly read: string;
  /** Cron's five fields; where they are given, days and time are not asked. */
  readonly cron: string;
  readonly zone: string;
  readonly holidays: string;
  /** A country or region, as DE-BW, whose public holidays are left out, too; empty for none. */
  readonly holidaysOf: string;
  readonly missed: "skip" | "catch_up";
  readonly from: string;
  readonly to: string;
  readonly item: string;
  /** Instead of an item: what people call something that has no master data. */
  readonly thing: string;
  readonly quantity: string;
  readonly priority: Priority;
  readonly vehicle: string;
  /** What its vehicle must be able to carry beside what the material asks for. */
  readonly ability: string;
  /** Whether nobody else may carry it, for always. */
  readonly only: boolean;
  readonly customer: string;
  readonly reference: string;
  readonly lines: readonly Line[];
  /** Hours from its moment until an order is due; empty for no due time. */
  readonly dueH: string;
}

export function empty(zone: string): Written {
  return {
    name: "", kind: "transport", days: ["1", "2", "3", "4", "5"], time: "06:00", read: "", cron: "", zone, holidays: "", holidaysOf: "", missed: "skip",
    from: "", to: "", item: "", thing: "", quantity: "", priority: "normal", vehicle: "", ability: "", only: true,
    customer: "", reference: "", lines: [NO_LINE], dueH: "",
  };
}

export function calendarOf({ cron, days, read, time }: Written): string {
  if (cron.trim() !== "") return cron.trim();
  const [hour, minute] = time.split(":").map(Number);
  const on = DAYS.filter((day) => days.includes(day));
  const calendar = `${minute ?? 0} ${hour ?? 0} * * ${on.length === DAYS.length || on.length === 0 ? "*" : on.join(",")}`;
  return JSON.stringify(rhythmOf(calendar)) === JSON.stringify(rhythmOf(read)) ? read : calendar;
}

/** Days, time and cron's fields of a calendar: one that days and a time of day cannot tell stands in cron's fields, and no day is ticked. */
function whenOf(calendar: string): Pick<Written, "days" | "time" | "read" | "cron"> {
  const rhythm = rhythmOf(calendar);
  if (rhythm === null || !isWeekly(rhythm)) return { days: [], time: "06:00", read: "", cron: calendar };
  const [timeMin = 0] = rhythm.timesMin;
  const two = (number: number): string => String(number).padStart(2, "0");
  return { days: rhythm.days.length === 0 ? DAYS : rhythm.days, time: `${two(Math.floor(timeMin / 60))}:${two(timeMin % 60)}`, read: calendar, cron: "" };
}

/** Whether days of the week and one time of day tell it. */
function isWeekly({ dates, months, timesMin }: Rhythm): boolean {
  return dates.length === 0 && months.length === 0 && timesMin.length === 1;
}

export function writtenOf(schedule: Schedule): Written {
  const { holidays, holidays_of, missed, name, order, transport } = schedule;
  const asked = order ?? transport;
  return {
    ...empty(schedule.time_zone),
    name,
    kind: order ? "order" : "transport",
    ...whenOf(schedule.calendar),
    holidays: holidays.join(" "),
    holidaysOf: holidays_of,
    missed: missed === "catch_up" ? "catch_up" : "skip",
    priority: asked && isPriority(asked.priority) ? asked.priority : "normal",
    ...(transport && {
      from: transport.from ?? "",
      to: transport.to ?? "",
      item: transport.item ?? "",
      thing: transport.thing ?? "",
      quantity: String(transport.quantity ?? ""),
      vehicle: transport.vehicle ?? "",
      ability: transport.ability ?? "",
      only: transport.vehicle_only,
    }),
    ...(order && {
      customer: order.customer,
      reference: order.reference ?? "",
      lines: order.items.map(({ product, quantity }) => ({ product, quantity: String(quantity) })),
      dueH: order.due_after_s === null ? "" : String(order.due_after_s / 3600),
    }),
  };
}

export function daysOf(holidays: string): string[] {
  return holidays.split(/[\s,;]+/).filter((day) => day !== "");
}

/** What is no number goes as it was written, for the gateway says best what is wrong with it. */
function numberOf(written: string, pattern = /^\d+$/): number {
  const text = written.trim();
  return pattern.test(text) ? Number(text) : (text as unknown as number);
}

/** What is sent: a transport or an order, never both. */
export function draftOf(written: Written): Omit<ScheduleDraft, "paused"> {
  const { holidaysOf, missed, name, zone } = written;
  return {
    name: name.trim(),
    calendar: calendarOf(written),
    time_zone: zone.trim(),
    holidays: daysOf(written.holidays),
    holidays_of: holidaysOf.trim(),
    missed,
    ...(written.kind === "order" ? { order: orderOf(written) } : { transport: transportOf(written) }),
  };
}

function transportOf({ ability, from, item, only, priority, quantity, thing, to, vehicle }: Written): NonNullable<ScheduleDraft["transport"]> {
  return {
    from: from === "" ? null : from,
    to: to === "" ? null : to,
    item: item === "" ? null : item,
    thing: thing === "" ? null : thing,
    quantity: quantity === "" ? null : numberOf(quantity),
    priority,
    vehicle: vehicle === "" ? null : vehicle,
    vehicle_only: only,
    ability: ability === "" ? null : ability,
  };
}

function orderOf({ customer, dueH, lines, priority, reference }: Written): NonNullable<ScheduleDraft["order"]> {
  const hours = numberOf(dueH.replace(",", "."), /^\d+(\.\d+)?$/);
  return {
    customer: customer.trim(),
    reference: reference.trim() === "" ? null : reference.trim(),
    items: lines.map(({ product, quantity }) => ({ product, quantity: numberOf(quantity) })),
    priority,
    due_after_s: dueH.trim() === "" ? null : typeof hours === "number" ? Math.round(hours * 3600) : hours,
  };
}

const PARTS: Readonly<Record<string, string>> = { name: "name", calendar: "cron", time_zone: "zone", holidays: "holidays", holidays_of: "holidaysOf" };
const ORDER_PARTS: Readonly<Record<string, string>> = { customer: "customer", reference: "reference", items: "lines", due_after_s: "dueH" };

/** At which part of the form a complaint of the gateway is shown; empty for the whole form. */
export function partOf(field: string): string {
  const line = /^order\.items\[(\d+)\]/.exec(field);
  if (line) return `line.${line[1] ?? ""}`;
  const [head = "", rest = ""] = field.replace(/\[\d+\].*/, "").split(".");
  if (head === "order") return ORDER_PARTS[rest] ?? "";
  if (head !== "transport") return PARTS[head] ?? "";
  return ["from", "to", "item", "quantity", "vehicle", "ability"].includes(rest) ? rest : "";
}

/** A moment as the clock of its time zone shows it. */
export function shown(moment: string, zone: string, language: string): string {
  const options = { weekday: "short", day: "numeric", month: "short", hour: "2-digit", minute: "2-digit", hourCycle: "h23", timeZone: zone } as const;
  return new Intl.DateTimeFormat(language === "en" ? "en-GB" : language, options).format(new Date(moment));
}

/** Moments that are yet to come: of one that is past nothing can be taken back. */
export function coming(moments: readonly string[], nowMs: number): string[] {
  return moments.filter((moment) => Date.parse(moment) > nowMs);
}

/** As many days off are named. */
const NAMED = 3;

/** Days off from a day on, the next ones by their dates, and how many more there are. */
export function daysOff(holidays: readonly string[], from: string, language: string): string[] {
  const date = new Intl.DateTimeFormat(language === "en" ? "en-GB" : language, { day: "numeric", month: "short", year: "numeric", timeZone: "UTC" });
  const coming = holidays.filter((day) => day >= from).sort();
  const more = coming.length - NAMED;
  return [...coming.slice(0, NAMED).map((day) => date.format(new Date(day))), ...(more > 0 ? [`+${more}`] : [])];
}

/** The short name of a day of the week. */
export function dayName(day: string, language: string): string {
  // The 4th of January 1970 was a Sunday.
  return new Intl.DateTimeFormat(language, { weekday: "short", timeZone: "UTC" }).format(new Date((3 + Number(day)) * 86_400_000));
}
