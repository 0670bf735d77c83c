/** A short word with a tone; the tone never says more than the word. */
import type { ComponentChildren } from "preact";

export type Tone = "normal" | "warn" | "alarm" | "chosen";

export function Tag({ tone = "normal", children }: { tone?: Tone; children: ComponentChildren }) {
  return <span class={`tag tag-${tone}`}>{children}</span>;
}

export function toneOfMachine(status: string): Tone {
  if (status === "error" || status === "lost") return "alarm";
  return status === "starved" || status === "blocked" ? "warn" : "normal";
}

export function toneOfAtv(status: string): Tone {
  if (status === "error" || status === "lost") return "alarm";
  return status === "stopped" ? "warn" : "normal";
}
