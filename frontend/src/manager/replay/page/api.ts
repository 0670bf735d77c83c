/** What the replay asks of the gateway. */
import { bodyOf, gateway } from "../../../api/gateway";
import type { components } from "../../../api/types";
import type { Film, Overview, Range } from "./film";
import type { Spell } from "./strips";

export type Knowledge = components["schemas"]["KnowledgeView"];

const iso = (atS: number): string => new Date(atS * 1000).toISOString();

export async function fetchFilm(sinceS: number, untilS: number, everyS: number): Promise<Film> {
  const query = { since: iso(sinceS), until: iso(Math.max(sinceS, untilS)), every_s: everyS };
  return await bodyOf(gateway.GET("/api/replay/film", { params: { query } }));
}

export async function fetchOverview({ fromS, toS }: Range): Promise<Overview> {
  return await bodyOf(gateway.GET("/api/replay/overview", { params: { query: { since: iso(fromS), until: iso(toS), steps: 160 } } }));
}

export async function fetchKnowledge(agent: string, atS: number): Promise<Knowledge> {
  return await bodyOf(gateway.GET("/api/agents/{agent}/knowledge", { params: { path: { agent }, query: { at: iso(atS) } } }));
}

export interface Told {
  readonly items: readonly Spell[];
  /** Whether that is all of it. */
  readonly isWhole: boolean;
}

/** What agents did; `agent` is whose, all of them without it. */
export async function fetchSpells({ fromS, toS }: Range, agent?: string): Promise<Told> {
  const answer = await bodyOf(gateway.GET("/api/spells", { params: { query: { since: iso(fromS), until: iso(toS), ...(agent === undefined ? {} : { agent: [agent] }) } } }));
  return { items: answer.items, isWhole: answer.is_whole };
}
