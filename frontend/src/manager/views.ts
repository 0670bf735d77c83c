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
/** The plain transport, or the task that is carried, whose page is shown; empty for none. */
export const shownTransport = signal("");

/** What else the address says, as what is looked for in a list; empty for nothing. */
export type Asked = Readonly<Record<string, string>>;
export const asked = signal<Asked>({});

export function viewFrom(hash: string): ViewName {
  const name = hash.split(/[/?]/, 1)[0];
  return VIEWS.find((each) => `#${each}` === name) ?? "plant";
}

/** The order in an address `#orders/O-…`, or the plain transport in `#transports/T-…`; empty when there is none. */
export function namedIn(hash: string, list: "orders" | "transports"): string {
  const start = `#${list}/`;
  const name = hash.startsWith(start) ? (hash.slice(start.length).split("?", 1)[0] ?? "") : "";
  try {
    return decodeURIComponent(name);
  } catch {
    return name; // Nobody has written it that way; it is one that there is not.
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
 * replaced: letters that are typed are no steps. Nothing is said once somebody has left for another view, which one is told of a little later.
 */
export function ask(more: Asked, how: "step" | "replace" = "step"): void {
  if (viewFrom(location.hash) !== view.peek()) return;
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

export function addressOfTransport(transport: string): string {
  return `#transports/${encodeURIComponent(transport)}`;
}

/** `T-…-2`, or `T-….3-2` by a third life of its destination. */
const ATTEMPT = /^(T-[0-9A-Z]{9}-[0-9A-Z]{4})(?:\.\d+)?-\d+$/;

/** The plain transport that a task is an attempt at; empty for a task of another kind. */
export function transportOf(task: string): string {
  return ATTEMPT.exec(task)?.[1] ?? "";
}

/** Whether something is called as plain transports are. */
export function isTransport(id: string): boolean {
  return transportOf(`${id}-1`) === id;
}

/**
 * Where the story of a task is told: on the page of the plain transport that it is an attempt at, on its order's page, where a transport is chosen, or on
 * a page of its own. Empty for what is made for no order.
 */
export function storyOf({ id, kind, order }: { readonly id: string; readonly kind: string; readonly order: string }): string {
  const called = transportOf(id);
  if (called !== "") return addressOfTransport(called);
  if (order === "") return kind === "transport" ? addressOfTransport(id) : "";
  return addressWith(addressOf(order), { transport: kind === "transport" ? id : "" });
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
      shownOrder.value = namedIn(location.hash, "orders");
      shownTransport.value = namedIn(location.hash, "transports");
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
