/** Lets the panel open without a network, where the browser allows it: over HTTPS, or on the server itself. */

const WORKER = "/operator/worker.js";

export function installShell(): void {
  if (!("serviceWorker" in navigator)) return;
  // The panel works all the same without it.
  navigator.serviceWorker.register(WORKER, { scope: "/operator" }).catch(() => undefined);
}
