import { readFileSync } from "node:fs";
import { describe, expect, test } from "vitest";

const css = readFileSync(new URL("./tokens.css", import.meta.url), "utf8");
const blocks = css.split("{").slice(1).map(colours).filter((block) => block.size > 10);
const [light, dark, systemDark] = blocks;

function colours(block: string): Map<string, string> {
  const body = block.split("}")[0] ?? "";
  return new Map([...body.matchAll(/--([\w-]+):\s*(#[0-9a-f]{6})/g)].map(([, name = "", hex = ""]) => [name, hex]));
}

function luminance(hex: string): number {
  const [r = 0, g = 0, b = 0] = [1, 3, 5].map((at) => {
    const value = parseInt(hex.slice(at, at + 2), 16) / 255;
    return value <= 0.03928 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4;
  });
  return 0.2126 * r + 0.7152 * g + 0.0722 * b;
}

/** WCAG 2, contrast ratio. */
function contrast(block: Map<string, string> | undefined, front: string, back: string): number {
  const [a = 0, b = 0] = [front, back].map((name) => luminance(block?.get(name) ?? "")).sort((x, y) => y - x);
  return (a + 0.05) / (b + 0.05);
}

const TEXT: [string, string[]][] = [
  ["ink", ["panel", "raised", "bg"]],
  ["ink-2", ["panel", "raised", "bg", "floor", "lane", "chosen-soft", "alarm-soft"]],
  ["ink-3", ["panel", "raised", "bg"]],
  ["chosen", ["panel", "chosen-soft", "raised", "floor"]],
  ["warn", ["panel", "warn-soft", "raised"]],
  ["alarm", ["panel", "alarm-soft", "raised", "floor"]],
  ["good", ["panel"]],
  ["on-chosen", ["chosen"]],
  ["steel-ink", ["panel", "wall", "floor"]],
];
const PARTS: [string, string[]][] = [
  ["steel", ["panel", "floor"]],
  ["edge", ["panel", "raised"]],
  ["warn", ["lane"]],
  ["heat", ["lane"]],
];

describe.each([["light", light], ["dark", dark]] as const)("the %s theme", (_name, block) => {
  test.each(TEXT)("writes %s legibly on %j (4.5:1)", (front, backs) => {
    for (const back of backs) expect(contrast(block, front, back)).toBeGreaterThanOrEqual(4.5);
  });

  test.each(PARTS)("draws %s visibly on %j (3:1)", (front, backs) => {
    for (const back of backs) expect(contrast(block, front, back)).toBeGreaterThanOrEqual(3);
  });
});

describe("the scheme of the paper", () => {
  const block = new Map([...(light ?? []), ...(css.split("{").map(colours).find((each) => each.has("vehicle")) ?? [])]);

  test.each([
    ["machine-ink", "machine"], ["machine-chosen", "machine"], ["machine-part", "machine"],
  ])("writes %s legibly on %s (4.5:1)", (front, back) => {
    expect(contrast(block, front, back)).toBeGreaterThanOrEqual(4.5);
  });

  test.each([
    ["machine", "lane"], ["machine", "floor"], ["machine-sign", "machine"], ["vehicle", "lane"], ["link", "floor"],
  ])("draws %s visibly on %s (3:1)", (front, back) => {
    expect(contrast(block, front, back)).toBeGreaterThanOrEqual(3);
  });
});

test("dark is the same, chosen or left to the system", () => {
  expect(systemDark).toEqual(dark);
  expect([...(light?.keys() ?? [])]).toEqual([...(dark?.keys() ?? [])]);
});
