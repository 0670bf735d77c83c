/** Light, dark, as the system wishes, or light with the map in the colours of the paper. `init.ts` applies the remembered choice before first paint. */
import { effect, signal } from "@preact/signals";
import { recall, remember } from "../memory";

export const THEMES = ["system", "light", "dark", "paper"] as const;
export type Theme = (typeof THEMES)[number];

/** Also read by `init.ts`, which may not import. */
const KEY = "dray.theme";

export const theme = signal<Theme>(themeFrom(recall(KEY)));
/** Grows whenever the colours on the page have changed, for whoever paints a canvas. */
export const colours = signal(0);

export function themeFrom(stored: string | null): Theme {
  return THEMES.find((each) => each === stored) ?? "system";
}

export function followTheme(): void {
  const repaint = (): void => {
    colours.value = colours.peek() + 1;
  };
  effect(() => {
    const chosen = theme.value;
    if (chosen === "system") delete document.documentElement.dataset.theme;
    else document.documentElement.dataset.theme = chosen;
    remember(KEY, chosen);
    repaint();
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", repaint);
}
