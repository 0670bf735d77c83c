/** Where somebody goes on who has dealt with one alert of a list. */

/** The button of the alert after this one, else of the one before; the way to all alerts when none is left. */
export function nextAfter(button: Element): HTMLElement | null {
  const list = button.closest("ul, tbody") ?? document;
  const all = [...list.querySelectorAll<HTMLElement>(".take")];
  const place = all.findIndex((each) => each === button);
  return all[place + 1] ?? all[place - 1] ?? document.querySelector<HTMLElement>(".alerts-button");
}
