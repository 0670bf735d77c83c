import type { ComponentChildren } from "preact";
import { t } from "../../text/manager";

interface Props {
  /** What a button with this `popovertarget` opens. */
  id: string;
  title: string;
  children: ComponentChildren;
}

/** What lies over the page until it is closed. */
export function Sheet({ id, title, children }: Props) {
  return (
    <div id={id} popover="auto" class="sheet" role="dialog" aria-label={title}>
      <header class="card-head">
        <h2>{title}</h2>
        <div class="card-aside">
          <button type="button" class="button small" popovertarget={id} popovertargetaction="hide">
            {t("sheet.close")}
          </button>
        </div>
      </header>
      {children}
    </div>
  );
}
