/** What a panel does when its session has ended, whoever notices it first. */

let whenLoggedOut: () => void = () => undefined;

export function onLoggedOut(call: () => void): void {
  whenLoggedOut = call;
}

export function tellLoggedOut(): void {
  whenLoggedOut();
}

/** Leaves for the login, and comes back to this very view after it. */
export function toLogin(): void {
  location.assign(`/login?next=${encodeURIComponent(location.pathname + location.hash)}`);
}
