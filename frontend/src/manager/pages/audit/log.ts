/** The page of the audit log that the address asks for. */
import { computed } from "@preact/signals";
import { fetchAudit } from "../../../api/client";
import { usePaged } from "../../parts/pages/paged";
import { asked } from "../../views";
import { filterFrom, queryOf } from "./filter";

export const filter = computed(() => filterFrom(asked.value));
export const oldestFirst = computed(() => asked.value.sort === "oldest");

/** Reads what is wanted for as long as somebody looks. */
export function useLog() {
  return usePaged(async (_, place) => await fetchAudit({ ...queryOf(filter.value), ...place, oldest_first: oldestFirst.value }));
}
