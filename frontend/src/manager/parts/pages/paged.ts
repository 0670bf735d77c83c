/** A list of all there ever was, page by page, as the address asks for it. */
import { type ReadonlySignal, signal, useComputed, useSignal, useSignalEffect } from "@preact/signals";
import { useRef } from "preact/hooks";
import type { Printing } from "../paper/PrintAll";
import { type Refreshed, useRefreshed } from "../../refreshed";
import { ask, type Asked, asked } from "../../views";

export interface PageOf<T> {
  readonly items: readonly T[];
  readonly next_cursor: string | null;
  /** How many there are on all pages; null where nobody has counted. */
  readonly total?: number | null;
}

/** What stands beside the title of a list: how many there are, or how many are on this page, and that there are more. */
export function countOf(page: PageOf<unknown> | null): { count: number; more: boolean } {
  const total = page?.total ?? null;
  return total === null ? { count: page?.items.length ?? 0, more: page?.next_cursor != null } : { count: total, more: false };
}

interface Paged<T> extends Pick<Refreshed<unknown>, "again" | "failed"> {
  /** All that there is, while it is printed. */
  readonly page: ReadonlySignal<PageOf<T> | null>;
  readonly printing: Printing;
}

/** As many as can be looked through at once. */
const PAGE = 50;
/** As many as the gateway gives at once: for who reads all of them. */
const PAGE_MOST = 500;
/** What people and agents do shows itself in that time; what the stream tells of shows itself at once. */
const AGAIN_MS = 5000;

const NOTHING_NEW = signal("");

/** Where the pages began that led to the one that is shown; who came by a link has none. */
const before = signal<readonly string[]>([]);

/** Where a page begins, and how many are on it, as the gateway is asked. */
interface Place {
  readonly limit: number;
  readonly cursor?: string;
}

function placeOf(after: string, limit: number): Place {
  return after === "" ? { limit } : { limit, cursor: after };
}

/**
 * @param fetchPage asks for what the address says; its signals are followed
 * @param newest another value whenever there is something new to be read
 */
export function usePaged<T>(fetchPage: (said: Asked, place: Place) => Promise<PageOf<T>>, newest: ReadonlySignal<string> = NOTHING_NEW): Paged<T> {
  const { again, answer, failed } = useRefreshed(async () => {
    const said = asked.value;
    return { said, page: await fetchPage(said, placeOf(said.after ?? "", PAGE)) };
  }, AGAIN_MS);
  const seen = useRef(newest.peek());
  useSignalEffect(() => {
    if (newest.value === seen.current) return;
    seen.current = newest.value;
    again();
  });
  const whole = useSignal<PageOf<T> | null>(null);
  const page = useComputed(() => {
    if (whole.value) return whole.value;
    const found = answer.value;
    // Where a page of another list ended is no place in this one: it is not turned before this one has come.
    if (found === null || found.said === asked.value) return found?.page ?? null;
    // Nor are its rows what is asked for, when that cannot be read.
    return failed.value === null ? { ...found.page, next_cursor: null } : null;
  });
  const fetchAfter = (after: string): Promise<PageOf<T>> => fetchPage(asked.peek(), placeOf(after, PAGE_MOST));
  return { again, failed, page, printing: { fetchAfter, whole } };
}

/** Narrows a list down; what was looked at before is another list. */
export function narrow(by: Asked, how: "step" | "replace" = "step"): void {
  before.value = [];
  ask({ ...by, after: "" }, how);
}

export function turnTo(next: string): void {
  before.value = [...before.value, asked.value.after ?? ""];
  ask({ after: next });
}

export function turnBack(): void {
  const to = before.value.at(-1) ?? "";
  before.value = before.value.slice(0, -1);
  ask({ after: to });
}

/** The next order by this column: another one begins as people read it, the same one turns round. */
export function sortBy(name: string, descendingAtFirst = false): void {
  const { sort, down } = asked.value;
  narrow({ sort: name, down: sort === name ? (down === "yes" ? "no" : "yes") : descendingAtFirst ? "yes" : "no" });
}
