/** Hands on the cards: whether there is one, and whether it meets what it has seen there. */
import { isSettling } from "./settling";

/** A second touch often follows the first one. */
const LINGER_MS = 1500;

/**
 * Somebody has a finger, or the keyboard, on the cards: then they must not change places.
 *
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
  }, { ...options, capture: true });
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

/** Long enough to be read. */
const SAID_MS = 2_000;

/**
 * A touch on a card that has come to its place just now was meant for what was there before: it does not count, and that is said.
 *
 * @param element whatever holds the cards
 * @param onRefused told the vehicle, and null when that was said for long enough
 * @returns how to stop listening
 */
export function refuseTooSoon(
  element: HTMLElement,
  onRefused: (id: string | null) => void,
): () => void {
  const stopping = new AbortController();
  let timer: number | undefined;
  let refused = false;
  const refuse = (event: Event): void => {
    event.preventDefault();
    event.stopPropagation();
  };
  element.addEventListener("pointerdown", (event) => {
    const card = event.target instanceof Element ? event.target.closest(".vehicle") : null;
    const id = card?.id.replace(/^vehicle-/, "") ?? "";
    refused = isSettling(id);
    if (!refused) return;
    refuse(event);
    onRefused(id);
    clearTimeout(timer);
    timer = window.setTimeout(() => {
      onRefused(null);
    }, SAID_MS);
  }, { signal: stopping.signal, capture: true });
  // The click of that touch; a keyboard's has no touch before it.
  element.addEventListener("click", (event) => {
    if (refused && event.detail > 0) refuse(event);
    refused = false;
  }, { signal: stopping.signal, capture: true });
  return () => {
    clearTimeout(timer);
    stopping.abort();
  };
}
