import { useSignal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect, useRef } from "preact/hooks";

/** Long enough that no sleeve does it, short enough that nobody thinks it is broken. */
const HOLD_MS = 800;

interface Props {
  class: string;
  disabled: boolean;
  children: ComponentChildren;
  onHeld: () => void;
}

/**
 * A button that is pressed and held, by finger, mouse or key. Who uses a screen reader has chosen it on
 * purpose and need not hold it.
 */
export function HoldButton({ children, class: name, disabled, onHeld }: Props) {
  const holding = useSignal(false);
  const timer = useRef<number | undefined>(undefined);
  /** When the finger or the key came down, on the clock of events. */
  const sinceMs = useRef(0);
  const end = (): void => {
    clearTimeout(timer.current);
    holding.value = false;
  };
  const held = (): void => {
    if (!holding.value) return;
    end();
    onHeld();
  };
  const begin = ({ timeStamp }: Event): void => {
    if (holding.value) return;
    holding.value = true;
    sinceMs.current = timeStamp;
    timer.current = window.setTimeout(held, HOLD_MS);
  };
  /** A tablet that is busy tells of it before its own timer: what counts is when it was let go. */
  const letGo = ({ timeStamp }: Event): void => {
    if (timeStamp - sinceMs.current >= HOLD_MS) held();
    else end();
  };
  useEffect(() => () => {
    clearTimeout(timer.current);
  }, []);
  useEffect(() => {
    if (disabled) end();
  });
  return (
    <button
      type="button"
      class={`hold ${holding.value ? "holding" : ""} ${name}`}
      style={{ "--hold": `${HOLD_MS}ms` }}
      disabled={disabled}
      onPointerDown={(event) => {
        if (event.button === 0) begin(event);
      }}
      onPointerUp={letGo}
      onPointerLeave={end}
      onPointerCancel={end}
      onContextMenu={(event) => {
        event.preventDefault();
      }}
      onKeyDown={(event) => {
        if (!isPress(event)) return;
        // The browser's own click would come at once.
        event.preventDefault();
        if (!event.repeat) begin(event);
      }}
      onKeyUp={(event) => {
        if (!isPress(event)) return;
        event.preventDefault();
        letGo(event);
      }}
      onBlur={end}
      onClick={(event) => {
        // Neither finger nor key: a screen reader, or a voice.
        if (event.detail === 0) onHeld();
      }}
    >
      {children}
    </button>
  );
}

function isPress(event: KeyboardEvent): boolean {
  return event.key === "Enter" || event.key === " ";
}
