/** Whether somebody has a finger, or the keyboard, on the cards: then they must not change places. */

/** A second touch often follows the first one. */
const LINGER_MS = 1500;

/**
 * @param element whatever holds the cards
 * @param onHeld told whenever that begins and ends
 * @returns how to stop listening
 */
export function watchTouch(element: HTMLElement, onHeld: (held: boolean) => void): () => void {
  const stopping = new AbortController();
  const options = { signal: stopping.signal, passive: true };
  let timer: number | undefined;
  let keys = false;
  const letGo = (): void => {
    clearTimeout(timer);
    timer = window.setTimeout(() => {
      onHeld(keys);
    }, LINGER_MS);
  };
  element.addEventListener("pointerdown", () => {
    clearTimeout(timer);
    onHeld(true);
  }, options);
  addEventListener("pointerup", letGo, options);
  addEventListener("pointercancel", letGo, options);
  element.addEventListener("focusin", ({ target }) => {
    keys = target instanceof Element && target.matches(":focus-visible");
    if (keys) onHeld(true);
  }, options);
  element.addEventListener("focusout", () => {
    keys = false;
    letGo();
  }, options);
  return () => {
    clearTimeout(timer);
    stopping.abort();
  };
}
