/** Which charts there are, and what is drawn in each. */
import type { KpiHistory } from "../../../api/types";
import { type Figure, transportsPerHour } from "./history";

/** A colour of the design tokens. Grey is normal; what should not be is amber or red. */
export type Ink = "steel-ink" | "steel" | "wall" | "line" | "warn" | "alarm";

export interface Line {
  readonly figure: Figure;
  /** Its name in the catalogue, after `kpis.`. */
  readonly name: LineName;
  readonly ink: Ink;
  /** So that lines differ without colour, too. */
  readonly dashed?: boolean;
  /** So is a part of a stack whose grey is near to the next one's. */
  readonly hatched?: boolean;
}

export type LineName =
  | "moving" | "waiting" | "charging" | "idle" | "blocked" | "silent"
  | "onTime" | "starved" | "p50" | "p95" | "empty" | "vehicles" | "machines"
  | "transports" | "commands" | "helps";

export type ChartName = "use" | "punctuality" | "durations" | "travel" | "availability" | "throughput" | "interventions";

export interface Chart {
  readonly name: ChartName;
  readonly unit: "percent" | "duration" | "count";
  /** `stack`: parts of one whole. `steps`: counts per step. */
  readonly kind: "lines" | "stack" | "steps";
  readonly lines: readonly Line[];
  /** Shares that are near to all the time: what is lost is shown, not what is there. */
  readonly zoomed?: boolean;
  /** Its figure over all steps is told, too: a step of a minute holds one or two of what is counted by the hour. */
  readonly mean?: (history: KpiHistory) => number | null;
}

export const CHARTS: readonly Chart[] = [
  {
    name: "use",
    unit: "percent",
    kind: "stack",
    lines: [
      { figure: "moving_frac", name: "moving", ink: "steel-ink" },
      { figure: "waiting_frac", name: "waiting", ink: "steel" },
      { figure: "charging_frac", name: "charging", ink: "wall", hatched: true },
      { figure: "idle_frac", name: "idle", ink: "line" },
      { figure: "blocked_frac", name: "blocked", ink: "warn" },
      { figure: "silent_frac", name: "silent", ink: "alarm" },
    ],
  },
  {
    name: "punctuality",
    unit: "percent",
    kind: "lines",
    lines: [
      { figure: "on_time_frac", name: "onTime", ink: "steel-ink" },
      { figure: "starved_frac", name: "starved", ink: "warn", dashed: true },
    ],
  },
  {
    name: "durations",
    unit: "duration",
    kind: "lines",
    lines: [
      { figure: "transport_p50_s", name: "p50", ink: "steel-ink" },
      { figure: "transport_p95_s", name: "p95", ink: "steel", dashed: true },
    ],
  },
  {
    name: "availability",
    unit: "percent",
    kind: "lines",
    zoomed: true,
    lines: [
      { figure: "atv_available_frac", name: "vehicles", ink: "steel-ink" },
      { figure: "machine_available_frac", name: "machines", ink: "steel", dashed: true },
    ],
  },
  {
    name: "travel",
    unit: "percent",
    kind: "lines",
    lines: [{ figure: "empty_frac", name: "empty", ink: "steel-ink" }],
  },
  {
    name: "throughput",
    unit: "count",
    kind: "lines",
    lines: [{ figure: "transports_per_hour", name: "transports", ink: "steel-ink" }],
    mean: transportsPerHour,
  },
  {
    name: "interventions",
    unit: "count",
    kind: "steps",
    lines: [
      { figure: "commands", name: "commands", ink: "steel-ink" },
      { figure: "helps", name: "helps", ink: "warn", dashed: true },
    ],
  },
];
