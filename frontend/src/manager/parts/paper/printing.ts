import { type Signal, signal } from "@preact/signals";
import { useEffect } from "preact/hooks";

/** Whether the page is printed just now, by whatever way. */
const printing = signal(false);

/** True while the page is printed: what waits for a click is shown then. */
export function usePrinting(): Signal<boolean> {
  useEffect(() => {
    // The browser's own way to print leaves time to draw anew after this event; `print()` in a click does not.
    const begin = (): void => { printing.value = true; };
    const end = (): void => { printing.value = false; };
    addEventListener("beforeprint", begin);
    addEventListener("afterprint", end);
    return () => {
      removeEventListener("beforeprint", begin);
      removeEventListener("afterprint", end);
    };
  }, []);
  return printing;
}

/** Shows what waits for a click, and has the browser print the page with it. */
export async function printPage(): Promise<void> {
  printing.value = true;
  try {
    await drawn();
    print();
  } finally {
    printing.value = false;
  }
}

/** What was changed stands there in the next picture. */
export async function drawn(): Promise<void> {
  await new Promise<void>((shown) => { requestAnimationFrame(() => setTimeout(shown)); });
}
