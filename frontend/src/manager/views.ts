/** The views of the panel and their addresses. */
import { signal } from "@preact/signals";

export const VIEWS = ["plant", "alerts", "orders", "fleet", "tasks", "watch", "promises", "kpis", "audit"] as const;
export type ViewName = (typeof VIEWS)[number];

export const view = signal<ViewName>("plant");

export function viewFrom(hash: string): ViewName {
  return VIEWS.find((each) => `#${each}` === hash) ?? "plant";
}

export function followAddress(): void {
  const follow = (): void => {
    view.value = viewFrom(location.hash);
  };
  addEventListener("hashchange", follow);
  follow();
}

export function go(to: ViewName): void {
  location.hash = to;
}
