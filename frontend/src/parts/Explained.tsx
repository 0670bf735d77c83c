import type { ComponentChildren } from "preact";
import { useId, useRef } from "preact/hooks";
import { zoomOf } from "./zoom";

const MARGIN_PX = 8;

/** What an element needs to be explained under the pointer, on the keyboard's way, and for who cannot see it. */
export interface About {
  "aria-describedby": string;
  onPointerEnter: (event: { currentTarget: Element }) => void;
  onPointerLeave: () => void;
  onFocus: (event: { currentTarget: Element }) => void;
  onBlur: () => void;
  onKeyDown: (event: KeyboardEvent) => void;
}

/** Something with what it means beside it, which lies above the page: a card would cut it off. */
export function Explained({ children, says }: { says: ComponentChildren; children: (about: About) => ComponentChildren }) {
  const id = useId();
  const note = useRef<HTMLSpanElement>(null);
  const show = ({ currentTarget }: { currentTarget: Element }): void => {
    if (!note.current || note.current.matches(":popover-open")) return;
    note.current.showPopover();
    const at = currentTarget.getBoundingClientRect();
    const { height, width } = note.current.getBoundingClientRect();
    const below = at.bottom + height + MARGIN_PX <= innerHeight;
    const zoom = zoomOf(note.current);
    note.current.style.top = `${(below ? at.bottom : Math.max(0, at.top - height)) / zoom}px`;
    note.current.style.left = `${Math.max(MARGIN_PX, Math.min(at.left, innerWidth - width - MARGIN_PX)) / zoom}px`;
  };
  const hide = (): void => {
    note.current?.hidePopover();
  };
  const about: About = {
    "aria-describedby": id,
    onPointerEnter: show,
    onPointerLeave: hide,
    onFocus: show,
    onBlur: hide,
    onKeyDown: (event) => {
      if (event.key === "Escape") hide();
    },
  };
  return (
    <>
      {children(about)}
      <span ref={note} class="term-says" role="tooltip" id={id} popover="manual">
        {says}
      </span>
    </>
  );
}
