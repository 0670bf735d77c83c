/** Where the keyboard goes on when what it was on is gone. */

const USABLE = "button:not(:disabled), a[href], input:not(:disabled), select:not(:disabled)";

/**
 * Once the page is drawn anew: whoever was on something that is gone goes on at `from`, or where that cannot be used at the first
 * thing in `place` that can, or where that is gone, too, at the content of the page.
 */
export function keepFocus(place: Element | null, from: Element | null = null): void {
  requestAnimationFrame(() => {
    if (document.activeElement !== null && document.activeElement !== document.body) return;
    const left = from instanceof HTMLElement && from.isConnected && from.matches(USABLE) ? from : null;
    const next = left ?? (place?.isConnected ? place.querySelector<HTMLElement>(USABLE) : null);
    (next ?? document.getElementById("content"))?.focus();
  });
}
