import type { Signal } from "@preact/signals";

/** Whether only these are wanted. */
export function Only({ label, wanted }: { label: string; wanted: Signal<boolean> }) {
  return (
    <label class="narrow only">
      <input
        type="checkbox"
        checked={wanted.value}
        onChange={(event) => {
          wanted.value = event.currentTarget.checked;
        }}
      />
      <span>{label}</span>
    </label>
  );
}
