/** Who may come in, and the keys of other systems: asked for by the view that sees to them. */
import { bodyOf, gateway } from "./gateway";
import { allOf } from "./pages";
import type { components } from "./types";

type Schemas = components["schemas"];

export type Person = Schemas["PersonAnswer"];
export type PersonDraft = Schemas["PersonDraft"];
export type Key = Schemas["KeyAnswer"];
export type NewKey = Schemas["NewKeyAnswer"];
export type KeyDraft = Schemas["KeyDraft"];
export type SecretKind = Schemas["SecretDraft"]["kind"];

export async function fetchPeople(): Promise<Person[]> {
  return await allOf(async (query) => await bodyOf(gateway.GET("/api/people", { params: { query } })));
}

export async function addPerson(draft: PersonDraft): Promise<Person> {
  return await bodyOf(gateway.POST("/api/people", { body: draft }));
}

/** A link that logs somebody in once; those from before work no more. */
export async function makeLoginLink(person: string): Promise<string> {
  return (await bodyOf(gateway.POST("/api/people/{person}/link", { params: { path: { person } } }))).url;
}

export async function giveSecret(person: string, kind: SecretKind, secret: string): Promise<Person> {
  return await bodyOf(gateway.PUT("/api/people/{person}/secret", { params: { path: { person } }, body: { kind, secret } }));
}

export async function movePerson(person: string, areas: string[]): Promise<Person> {
  return await bodyOf(gateway.PUT("/api/people/{person}/areas", { params: { path: { person } }, body: { areas } }));
}

/** Lets somebody log in no more, at once and everywhere, or again. */
export async function letIn(person: string, may: boolean): Promise<Person> {
  const params = { path: { person } };
  return await bodyOf(may ? gateway.POST("/api/people/{person}/enable", { params }) : gateway.POST("/api/people/{person}/disable", { params }));
}

export async function fetchKeys(): Promise<Key[]> {
  return await allOf(async (query) => await bodyOf(gateway.GET("/api/keys", { params: { query } })));
}

/** A new key: what it is shown by is told this one time. */
export async function makeKey(draft: KeyDraft): Promise<NewKey> {
  return await bodyOf(gateway.POST("/api/keys", { body: draft }));
}

export async function revokeKey(key: string): Promise<void> {
  await bodyOf(gateway.POST("/api/keys/{key}/revoke", { params: { path: { key } } }));
}
