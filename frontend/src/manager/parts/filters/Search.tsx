import type { Signal } from "@preact/signals";
import { t } from "../../../text/manager";

/** Narrows a table down to what holds these words. */
export function Search({ words }: { words: Signal<string> }) {
  return (
    <input
      class="filter"
      type="search"
      aria-label={t("filter.find")}
      placeholder={t("filter.find")}
      value={words.value}
      onInput={(event) => {
        words.value = event.currentTarget.value;
      }}
    />
  );
}
