/** Recurring work: asked for by the view that plans it. */
import { bodyOf, gateway } from "./gateway";
import { allOf } from "./pages";
import type { components } from "./types";

type Schemas = components["schemas"];

export type Schedule = Schemas["ScheduleAnswer"];
export type ScheduleDraft = Schemas["ScheduleDraft"];
export type ScheduleChange = Schemas["ScheduleChange"];

/** All of it, page after page. */
export async function fetchSchedules(): Promise<Schedule[]> {
  return await allOf(async (query) => await bodyOf(gateway.GET("/api/schedules", { params: { query } })));
}

export async function addSchedule(draft: ScheduleDraft): Promise<Schedule> {
  return await bodyOf(gateway.POST("/api/schedules", { body: draft }));
}

export async function changeSchedule({ etag, id }: Schedule, change: ScheduleChange): Promise<Schedule> {
  const params = { path: { schedule: id }, header: { "If-Match": etag } };
  return await bodyOf(gateway.PATCH("/api/schedules/{schedule}", { params, body: change }));
}

export async function removeSchedule({ etag, id }: Schedule): Promise<void> {
  await gateway.DELETE("/api/schedules/{schedule}", { params: { path: { schedule: id }, header: { "If-Match": etag } } });
}

/** The next moments of a calendar, in its time zone. */
export async function previewRuns(calendar: Schemas["PreviewDraft"]): Promise<readonly string[]> {
  return (await bodyOf(gateway.POST("/api/schedules/preview", { body: calendar }))).runs;
}
