import { useLayoutEffect, useRef } from "preact/hooks";
import { keepFocus } from "./keep-focus";

interface Props {
  asked: string;
  /** What stays as it is, and what is done: each says so by itself, whoever reads nothing else. */
  no: string;
  yes: string;
  busy: boolean;
  /** It cannot be done at this moment; that nothing is done can be said all the same. */
  blocked?: boolean;
  onNo: () => void;
  onYes: () => void;
}

/** Asks twice for what cannot be undone. The safe answer comes first and has the focus; answered, it is given back to what stands here then. */
export function Sure({ asked, blocked, busy, no, onNo, onYes, yes }: Props) {
  const safe = useRef<HTMLButtonElement>(null);
  /** The second click of a double one was meant for what stood here before: it takes no focus, and does nothing. */
  useLayoutEffect(() => {
    const still = (event: MouseEvent) => {
      if (event.detail > 1) event.preventDefault();
    };
    const place = safe.current?.closest(".sure")?.parentElement ?? null;
    safe.current?.focus();
    document.addEventListener("mousedown", still);
    return () => {
      document.removeEventListener("mousedown", still);
      keepFocus(place);
    };
  }, []);
  const meant = (act: () => void) => (event: MouseEvent) => {
    if (event.detail <= 1) act();
  };
  return (
    <span class="sure" role="group" aria-label={asked}>
      <span>{asked}</span>
      <button ref={safe} type="button" class="button small" disabled={busy} onClick={meant(onNo)}>
        {no}
      </button>
      <button type="button" class="button small grave" disabled={busy || blocked} onClick={meant(onYes)}>
        {yes}
      </button>
    </span>
  );
}
