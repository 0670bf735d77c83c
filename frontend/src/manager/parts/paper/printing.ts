import { type Signal, useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";

/** Whether the page is printed just now, by whatever way: what waits for a click is shown then. */
export function usePrinting(): Signal<boolean> {
  const printing = useSignal(false);
  useEffect(() => {
    const begin = (): void => { printing.value = true; };
    const end = (): void => { printing.value = false; };
    addEventListener("beforeprint", begin);
    addEventListener("afterprint", end);
    return () => {
      removeEventListener("beforeprint", begin);
      removeEventListener("afterprint", end);
    };
  }, [printing]);
  return printing;
}
