import { t } from "../../../text/manager";
import { asked } from "../../views";
import { turnBack, turnTo } from "./paged";

/** Turns the pages of a list; not there while all of it is on one. */
export function Pages({ next }: { next: string | null }) {
  const first = (asked.value.after ?? "") === "";
  if (first && next === null) return null;
  return (
    <nav class="pages" aria-label={t("pages.label")}>
      <button type="button" class="button small" disabled={first} onClick={turnBack}>
        {t("pages.before")}
      </button>
      <button type="button" class="button small" disabled={next === null} onClick={() => { if (next !== null) turnTo(next); }}>
        {t("pages.next")}
      </button>
    </nav>
  );
}
