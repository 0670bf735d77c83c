import type { ComponentChildren } from "preact";
import { useEffect, useId, useRef } from "preact/hooks";
import { zoomOf } from "../../parts/zoom";
import { Icon, type IconName } from "../../parts/Icon";

const GAP_PX = 6;
const MARGIN_PX = 8;

interface Props {
  icon: IconName;
  label: string;
  title: string;
  /** Told just before the sheet opens or closes: nothing can be typed on it before that. */
  onToggle?: (open: boolean) => void;
  /** What is on the sheet; it is given how to close it. */
  children: (close: () => void) => ComponentChildren;
}

/** A small button on a card, and the sheet that it opens beside itself. */
export function PopButton({ icon, label, title, onToggle, children }: Props) {
  const id = useId();
  const button = useRef<HTMLButtonElement>(null);
  const sheet = useRef<HTMLDivElement>(null);
  /** A card scrolls and would cut the sheet off: it opens above the page, beside its button. */
  const place = (): void => {
    if (!button.current || !sheet.current) return;
    const at = button.current.getBoundingClientRect();
    const { height, width } = sheet.current.getBoundingClientRect();
    const below = at.bottom + GAP_PX;
    const top = below + height + MARGIN_PX > innerHeight ? at.top - GAP_PX - height : below;
    const zoom = zoomOf(sheet.current);
    sheet.current.style.top = `${Math.max(MARGIN_PX, top) / zoom}px`;
    sheet.current.style.left = `${Math.max(MARGIN_PX, at.right - width) / zoom}px`;
  };
  /** What is on it may come later, or grow. */
  useEffect(() => {
    if (!sheet.current) return;
    const grown = new ResizeObserver(place);
    grown.observe(sheet.current);
    return () => {
      grown.disconnect();
    };
  }, []);
  return (
    <>
      <button ref={button} type="button" class="pop-button" popovertarget={id} title={title}>
        <Icon name={icon} />
        {label}
      </button>
      <div
        ref={sheet}
        id={id}
        popover="auto"
        class="pop-sheet card"
        // `toggle` comes some time after the sheet is open: what somebody quick has typed by then must stay.
        onBeforeToggle={(event) => onToggle?.(event.newState === "open")}
        onToggle={place}
      >
        {children(() => sheet.current?.hidePopover())}
      </div>
    </>
  );
}
