import type { ComponentChildren } from "preact";

interface Props {
  /** Null before anything was sent. */
  readonly of: { readonly good: boolean; readonly text: string } | null;
  /** Behind the words. */
  readonly children?: ComponentChildren;
}

/** What came of what a form has sent, told to who hears it, too. */
export function Outcome({ children, of }: Props) {
  return (
    <span role="status" class={`outcome outcome-${of?.good ? "good" : "bad"}`}>
      {of?.text}
      {children}
    </span>
  );
}
