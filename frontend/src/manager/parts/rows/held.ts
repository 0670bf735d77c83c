/** What held up a carrier that was late, as the gateway names it. Pure. */
const HELD = ["waits", "stopped", "blocked", "silent", "charges", "out"] as const;

export type HeldKey = (typeof HELD)[number] | "waitsFor";

/** The name in the catalogue; null for nothing, and for what this version does not know. */
export function heldKey(doing: string, by: string): HeldKey | null {
  if (doing === "waits" && by !== "") return "waitsFor";
  return HELD.find((each) => each === doing) ?? null;
}
