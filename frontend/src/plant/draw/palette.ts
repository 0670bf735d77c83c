/** The colours of the map, read from the design tokens, so that the canvas follows the theme. */

const TOKENS = [
  "floor", "line", "ink", "ink-2", "ink-3", "lane", "lane-mark", "heat", "wall", "steel", "steel-ink",
  "machine", "machine-edge", "machine-ink", "machine-chosen", "machine-part", "machine-sign", "vehicle", "link",
  "panel", "raised", "chosen", "chosen-soft", "on-chosen", "warn", "warn-soft", "alarm", "alarm-soft",
] as const;

type Token = (typeof TOKENS)[number];
export type Palette = Readonly<Record<Token, string>> & { readonly font: string };

export function readPalette(element: Element): Palette {
  const style = getComputedStyle(element);
  const colours = Object.fromEntries(
    TOKENS.map((token) => [token, style.getPropertyValue(`--${token}`).trim()]),
  ) as Record<Token, string>;
  return { ...colours, font: style.getPropertyValue("--font").trim() };
}
