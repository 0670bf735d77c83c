/** A short word with a tone; the tone never says more than the word. */
import type { ComponentChildren } from "preact";

export type Tone = "normal" | "warn" | "alarm" | "chosen";

export function Tag({ tone = "normal", children }: { tone?: Tone; children: ComponentChildren }) {
  return <span class={`tag tag-${tone}`}>{children}</span>;
}

const BAD: ReadonlySet<string> = new Set(["error", "lost", "shut_out"]);

export function toneOfMachine(status: string): Tone {
  if (BAD.has(status)) return "alarm";
  return status === "starved" || status === "blocked" ? "warn" : "normal";
}

export function toneOfAtv(status: string): Tone {
  if (BAD.has(status)) return "alarm";
  return status === "stopped" ? "warn" : "normal";
}
