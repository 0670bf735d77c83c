import { useId, useRef } from "preact/hooks";
import { Icon } from "../../parts/Icon";
import { world } from "../../stream/stream";
import { t } from "../../text/manager";
import { begin, busy } from "./act";
import { faultsOf, isOn, type Trial } from "./trials";

const GAP_PX = 6;
const MARGIN_PX = 8;

/** A button for the head of a card: what may go wrong with this one. Absent in a real factory. */
export function TrialMenu({ agent, kinds }: { agent: string; kinds: readonly Trial[] }) {
  const id = useId();
  const button = useRef<HTMLButtonElement>(null);
  const sheet = useRef<HTMLDivElement>(null);
  const known = world.value;
  if (!known?.trials) return null;
  const faults = faultsOf(known.faults.values(), agent);
  /** A card scrolls and would cut the sheet off: it opens above the page, beside its button. */
  const place = (): void => {
    if (!button.current || !sheet.current) return;
    const at = button.current.getBoundingClientRect();
    const { height, width } = sheet.current.getBoundingClientRect();
    const below = at.bottom + GAP_PX;
    const top = below + height + MARGIN_PX > innerHeight ? at.top - GAP_PX - height : below;
    sheet.current.style.top = `${Math.max(MARGIN_PX, top)}px`;
    sheet.current.style.left = `${Math.max(MARGIN_PX, at.right - width)}px`;
  };
  return (
    <>
      <button ref={button} type="button" class="trial-button" popovertarget={id} title={t("trial.hint")}>
        <Icon name="trial" />
        {t("trial.title")}
      </button>
      <div ref={sheet} id={id} popover="auto" class="trial-sheet card" onToggle={place}>
        <p class="faint">{t("trial.hint")}</p>
        {kinds.map((kind) => (
          <button
            key={kind}
            type="button"
            class="trial-choice"
            disabled={busy.value || isOn(faults, kind)}
            onClick={() => {
              sheet.current?.hidePopover();
              void begin(kind, agent);
            }}
          >
            {t(`trial.begin.${kind}`)}
          </button>
        ))}
      </div>
    </>
  );
}
