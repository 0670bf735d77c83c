import { useSignal } from "@preact/signals";
import type { ComponentChildren } from "preact";

interface Props {
  readonly value: string;
  /** What it is, to who hears it. */
  readonly label: string;
  readonly copy: string;
  readonly copied: string;
  readonly notCopied: string;
  readonly hint: string;
  /** Beside the button that copies it. */
  readonly children?: ComponentChildren;
}

/** What is told one time and kept nowhere: an address or a key, to be copied. */
export function Once({ children, copied, copy, hint, label, notCopied, value }: Props) {
  /** What was copied, and whether that was done; a new value has not been copied. */
  const done = useSignal<{ value: string; good: boolean } | null>(null);
  const take = async (): Promise<void> => {
    try {
      await navigator.clipboard.writeText(value);
      done.value = { value, good: true };
    } catch {
      done.value = { value, good: false };
    }
  };
  const told = done.value?.value === value ? done.value : null;
  return (
    <>
      <input class="link-address" readOnly value={value} aria-label={label} onFocus={(event) => { event.currentTarget.select(); }} />
      <p class="order-actions">
        <button type="button" class="button small" onClick={() => void take()}>
          {copy}
        </button>
        {children}
        <span role="status">{told && (told.good ? copied : notCopied)}</span>
      </p>
      <p class="muted">{hint}</p>
    </>
  );
}
