import type { Signal } from "@preact/signals";

interface Props {
  readonly title: string;
  readonly checks: readonly string[];
  /** How many of them somebody has looked at. */
  readonly done: Signal<number>;
}

/** A guided list: one thing after the other, and each is said to have been looked at. Touching the last one said takes it back. */
export function Checks({ checks, done, title }: Props) {
  const said = done.value;
  return (
    <ol class="checks" aria-label={title}>
      {checks.map((check, i) => (
        <li key={check}>
          <button
            type="button"
            class="button"
            aria-pressed={i < said}
            disabled={i > said || i < said - 1}
            onClick={() => {
              done.value = i < said ? i : i + 1;
            }}
          >
            {check}
          </button>
        </li>
      ))}
    </ol>
  );
}
