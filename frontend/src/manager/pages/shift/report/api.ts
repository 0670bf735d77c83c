/** What the shift report asks of the gateway. */
import { bodyOf, gateway } from "../../../../api/gateway";
import type { Against, Report, Shift, Targets } from "./shifts";

const iso = (atS: number): string => new Date(atS * 1000).toISOString();

export async function fetchReport({ fromS, untilS }: Shift, against: Against): Promise<Report> {
  const query = { from: iso(fromS), until: iso(untilS), against };
  return await bodyOf(gateway.GET("/api/reports/shift", { params: { query } }));
}

export function csvOf({ fromS, untilS }: Shift, against: Against): string {
  return `/api/reports/shift?${new URLSearchParams({ from: iso(fromS), until: iso(untilS), against, format: "csv" }).toString()}`;
}

export async function fetchTargets(): Promise<Targets> {
  return await bodyOf(gateway.GET("/api/reports/targets"));
}

export async function putTargets(targets: Record<string, number>): Promise<Targets> {
  return await bodyOf(gateway.PUT("/api/reports/targets", { body: { targets } }));
}
