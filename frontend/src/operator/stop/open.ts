/** The Stops that nobody can count on yet. */
import { computed, signal } from "@preact/signals";
import { world } from "../../stream/stream";
import { all } from "../commands/given";
import type { Command } from "../commands/life";
import { openOf } from "./unconfirmed";

/** Ids of those that a person has read and seen to. */
const seen = signal<ReadonlySet<string>>(new Set());

/** By vehicle. */
export const openStops = computed<ReadonlyMap<string, Command>>(() =>
  openOf(all.value, world.value?.atvs ?? new Map(), seen.value),
);

/** A person has looked at the vehicle. */
export function seeTo({ id }: Command): void {
  const known = new Set(all.value.map((command) => command.id));
  // No more of them than there are commands.
  seen.value = new Set([...seen.value, id].filter((each) => known.has(each)));
}
