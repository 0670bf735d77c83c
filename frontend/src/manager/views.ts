/** The views of the panel and their addresses. */
import { batch, signal } from "@preact/signals";

/** Those of the menu. */
export const MENU = ["plant", "orders", "products", "fleet", "tasks", "watch", "promises", "kpis", "audit"] as const;

/** Those that are led to from elsewhere, each with what the menu shows meanwhile. */
export const LED_TO = { alerts: null, replay: null, shift: "kpis", recurring: "orders", transports: "tasks", people: null } as const;

const VIEWS = [...MENU, ...(Object.keys(LED_TO) as (keyof typeof LED_TO)[])];
export type ViewName = (typeof VIEWS)[number];

export const view = signal<ViewName>("plant");
/** The order whose page is shown; empty for none. */
export const shownOrder = signal("");

/** What else the address says, as what is looked for in a list; empty for nothing. */
export type Asked = Readonly<Record<string, string>>;
export const asked = signal<Asked>({});

export function viewFrom(hash: string): ViewName {
  const name = hash.split(/[/?]/, 1)[0];
  return VIEWS.find((each) => `#${each}` === name) ?? "plant";
}

/** The order in an address `#orders/O-…`; empty when there is none. */
export function orderFrom(hash: string): string {
  const order = hash.startsWith("#orders/") ? (hash.slice("#orders/".length).split("?", 1)[0] ?? "") : "";
  try {
    return decodeURIComponent(order);
  } catch {
    return order; // Nobody has written it that way; it is an order that there is not.
  }
}

export function askedFrom(hash: string): Asked {
  const start = hash.indexOf("?");
  return start < 0 ? {} : Object.fromEntries(new URLSearchParams(hash.slice(start + 1)));
}

/** The address of a view, or of an order's page, with what else it is to say. */
export function addressWith(path: string, more: Asked): string {
  const said = new URLSearchParams(Object.entries(more).filter(([, value]) => value !== "")).toString();
  return said === "" ? path : `${path}?${said}`;
}

/**
 * Says something else in the address of what is shown. Going back leads to what it said before, unless that is to be
 * replaced: letters that are typed are no steps.
 */
export function ask(more: Asked, how: "step" | "replace" = "step"): void {
  const path = location.hash.split("?", 1)[0] ?? "";
  const address = addressWith(path === "" ? `#${view.value}` : path, { ...asked.value, ...more });
  if (address === location.hash) return;
  if (how === "step") history.pushState(null, "", address);
  else history.replaceState(null, "", address);
  asked.value = askedFrom(address);
}

export function addressOf(order: string): string {
  return `#orders/${encodeURIComponent(order)}`;
}

export function goToOrder(order: string): void {
  location.hash = addressOf(order);
}

/** The moment in an address `#replay/1893456000.5`, seconds since 1970; null when there is none. */
export function momentFrom(hash: string): number | null {
  const atS = hash.startsWith("#replay/") ? Number(hash.slice("#replay/".length)) : NaN;
  return Number.isFinite(atS) && atS > 0 ? atS : null;
}

/** Where the plant is shown as it was at a moment. */
export function addressOfMoment(atS: number): string {
  return `#replay/${atS.toFixed(1)}`;
}

export function followAddress(): void {
  const follow = (): void => {
    batch(() => {
      view.value = viewFrom(location.hash);
      shownOrder.value = orderFrom(location.hash);
      asked.value = askedFrom(location.hash);
    });
  };
  addEventListener("hashchange", follow);
  addEventListener("popstate", follow);
  follow();
}

export function go(to: ViewName): void {
  location.hash = to;
}
