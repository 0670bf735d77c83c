/** The page of the audit log that is shown, and how to turn it. */
import { effect, signal } from "@preact/signals";
import { type AuditPage, fetchAudit } from "../../../api/client";
import { problemText } from "../../problem-text";
import { type Filter, NOTHING, queryOf } from "./filter";

/** As many lines as can be looked through at once. */
const PAGE = 50;

export const filter = signal<Filter>(NOTHING);
/** Where the pages begin that lead to the one that is shown; the first one begins at "". */
export const cursors = signal<readonly string[]>([""]);
export const page = signal<AuditPage | null>(null);
export const failed = signal("");
export function narrow(by: Partial<Filter>): void {
  filter.value = { ...filter.value, ...by };
  cursors.value = [""];
}

export function older(): void {
  const next = page.value?.next_cursor;
  if (next) cursors.value = [...cursors.value, next];
}

export function newer(): void {
  if (cursors.value.length > 1) cursors.value = cursors.value.slice(0, -1);
}

/** The newest lines, as they are now. */
export function lookAgain(): void {
  // A new list is read even where it is the same one.
  cursors.value = [""];
}

/** Reads what is wanted for as long as somebody looks. Returns how to stop. */
export function followLog(): () => void {
  return effect(() => {
    const cursor = cursors.value.at(-1) ?? "";
    const place = cursor === "" ? {} : { cursor };
    let wanted = true;
    fetchAudit({ ...queryOf(filter.value), ...place, limit: PAGE }).then(
      (answer) => {
        if (!wanted) return;
        page.value = answer;
        failed.value = "";
      },
      (error: unknown) => {
        if (wanted) failed.value = problemText(error);
      },
    );
    return () => {
      wanted = false;
    };
  });
}
