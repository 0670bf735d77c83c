/** Where the keyboard goes on when what it was on is gone. */

const USABLE = "button:not(:disabled), a[href], input:not(:disabled), select:not(:disabled)";

/**
 * Once the page is drawn anew: whoever was on something that is gone goes on at the first thing in `place` that can be used, or
 * where that is gone, too, at the content of the page.
 */
export function keepFocus(place: Element | null): void {
  requestAnimationFrame(() => {
    if (document.activeElement !== null && document.activeElement !== document.body) return;
    const next = place?.isConnected ? place.querySelector<HTMLElement>(USABLE) : null;
    (next ?? document.getElementById("content"))?.focus();
  });
}
