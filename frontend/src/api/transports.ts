/** Plain transports: something is brought to a place, or taken away from it. */
import { bodyOf, gateway } from "./gateway";
import type { components } from "./types";

export type TransportAnswer = components["schemas"]["TransportAnswer"];
export type TransportStory = components["schemas"]["TransportStory"];
export type TaskStory = components["schemas"]["TaskStory"];
export type TransportState = components["schemas"]["TransportState"];
export type Priorities = components["schemas"]["PrioritiesAnswer"];
export type TransportDraft = components["schemas"]["TransportDraft"];

/** The newest from or to a place. */
export async function fetchTransports(place: string, limit: number): Promise<TransportAnswer[]> {
  return (await bodyOf(gateway.GET("/api/transports", { params: { query: { place, limit } } }))).items;
}

/** A page of all there ever were, the newest first. */
export async function fetchCalled(query: { q?: string; status?: TransportState[]; place?: string; sort?: "called" | "due"; descending?: boolean; limit: number; cursor?: string }): Promise<{ items: TransportAnswer[]; next_cursor: string | null; total: number | null }> {
  return await bodyOf(gateway.GET("/api/transports", { params: { query } }));
}

export async function fetchTransport(transport: string): Promise<TransportAnswer> {
  return await bodyOf(gateway.GET("/api/transports/{transport}", { params: { path: { transport } } }));
}

/** How it was given out, who carried it, and what happened. */
export async function fetchTransportStory(transport: string): Promise<TransportStory> {
  return await bodyOf(gateway.GET("/api/transports/{transport}/timeline", { params: { path: { transport } } }));
}

/** The same of one that nobody has called for: what a machine has brought for itself. */
export async function fetchTaskStory(task: string): Promise<TaskStory> {
  return await bodyOf(gateway.GET("/api/tasks/{task}/timeline", { params: { path: { task } } }));
}

/** @param key the same for every try: however often it is sent, it is done once */
export async function callTransport(draft: TransportDraft, key: string): Promise<TransportAnswer> {
  return await bodyOf(gateway.POST("/api/transports", { body: draft, params: { header: { "Idempotency-Key": key } } }));
}

/** Calls it off, as long as it is not on board. */
export async function callOff(transport: string): Promise<TransportAnswer> {
  return await bodyOf(gateway.POST("/api/transports/{transport}/cancel", { params: { path: { transport } } }));
}

/** Makes a link to its page for others; the address is told this once. */
export async function makeTransportLink(transport: string): Promise<components["schemas"]["NewLink"]> {
  return await bodyOf(gateway.POST("/api/transports/{transport}/links", { params: { path: { transport } }, body: {} }));
}

/** Takes all links of a transport back. */
export async function revokeTransportLinks(transport: string): Promise<void> {
  await bodyOf(gateway.DELETE("/api/transports/{transport}/links", { params: { path: { transport } } }));
}

/** How soon each priority is wanted, and for how long what waits is passed at the most. */
export async function fetchPriorities(): Promise<Priorities> {
  return await bodyOf(gateway.GET("/api/priorities"));
}
