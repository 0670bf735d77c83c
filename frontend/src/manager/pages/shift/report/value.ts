/** A figure as people read it. */
import { factoryTime } from "../../../../text/plant-time";
import { format, t } from "../../../../text/views/shift";
import type { Figure } from "./shifts";

export function valueText(unit: string, value: number | null): string {
  if (value === null) return t("shift.unknown");
  if (unit === "frac") return format.percent(value, 1);
  if (unit === "s") return factoryTime(value);
  if (unit !== "Wh") return format.count(value);
  return value >= 1000 ? `${format.number(value / 1000, 1)}\u202fkWh` : `${format.number(value, value < 100 ? 1 : 0)}\u202fWh`;
}

export function changeText({ before, unit, value }: Figure): string {
  if (value === null || before === null) return t("shift.unknown");
  const change = value - before;
  const sign = change > 0 ? "+" : change < 0 ? "−" : "±";
  return sign + valueText(unit, Math.abs(change));
}

export function targetText({ better, target, unit }: Figure): string {
  if (target === null) return t("shift.unknown");
  return t(better === "more" ? "shift.least" : "shift.most", { value: valueText(unit, target) });
}
