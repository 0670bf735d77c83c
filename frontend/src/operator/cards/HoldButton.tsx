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
  const begin = (): void => {
    if (holding.value) return;
    holding.value = true;
    timer.current = window.setTimeout(() => {
      holding.value = false;
      onHeld();
    }, HOLD_MS);
  };
  const end = (): void => {
    clearTimeout(timer.current);
    holding.value = false;
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
        if (event.button === 0) begin();
      }}
      onPointerUp={end}
      onPointerLeave={end}
      onPointerCancel={end}
      onContextMenu={(event) => {
        event.preventDefault();
      }}
      onKeyDown={(event) => {
        if (!isPress(event)) return;
        // The browser's own click would come at once.
        event.preventDefault();
        if (!event.repeat) begin();
      }}
      onKeyUp={(event) => {
        if (!isPress(event)) return;
        event.preventDefault();
        end();
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
