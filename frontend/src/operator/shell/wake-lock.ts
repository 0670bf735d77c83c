/** Keeps the screen on while the panel is in sight: a dark tablet shows no call for help. */

export function keepAwake(): void {
  const ask = (): void => {
    // Missing on plain HTTP, refused on a low battery: the panel works all the same.
    if (document.visibilityState !== "visible" || !("wakeLock" in navigator)) return;
    navigator.wakeLock.request("screen").catch(() => undefined);
  };
  // The browser takes the lock back whenever the page is hidden.
  document.addEventListener("visibilitychange", ask);
  ask();
}
