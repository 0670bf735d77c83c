/** A device that can vibrate does so. A newer browser refuses it, and complains, until somebody has touched the page. */
export function vibrate(): void {
  if (!("vibrate" in navigator)) return;
  const isTouched = !("userActivation" in navigator) || navigator.userActivation.hasBeenActive;
  if (isTouched) navigator.vibrate([200, 100, 200]);
}
