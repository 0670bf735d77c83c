/** A figure in words. */
import { format, t } from "../../../../text/views/records";
import type { Chart } from "../charts";

export function shownValue({ unit }: Pick<Chart, "unit">, value: number | null): string {
  if (value === null) return t("factory.none");
  if (unit === "percent") return format.percent(value, 1);
  return unit === "duration" ? format.duration(value) : format.count(value);
}
