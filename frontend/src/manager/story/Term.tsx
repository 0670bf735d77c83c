import type { ComponentChildren } from "preact";
import { Explained } from "../../parts/Explained";
import { speakAlso } from "../../text/speech";
import { t, tables } from "../../text/views/guide";

export type TermName = "epoch" | "round" | "p50" | "p95" | "suitability" | "watch" | "standby";

/** To be called once there is something to be explained: what words mean is no part of the first picture. */
export function learnTerms(): void {
  void speakAlso(tables);
}

/** A word of the trade, with what it means: under the pointer, on the keyboard's way, and for who cannot see it. */
export function Term({ children, name }: { name: TermName; children: ComponentChildren }) {
  return (
    <Explained says={t(`term.${name}`)}>
      {(about) => (
        <span class="term" tabIndex={0} {...about}>
          {children}
        </span>
      )}
    </Explained>
  );
}
