import { useSignal, useSignalEffect } from "@preact/signals";
import type { FunctionComponent } from "preact";
import { bring } from "../api/bring";

interface Props<Of> {
  readonly load: () => Promise<FunctionComponent<Of>>;
  /** What the part is given. */
  readonly of?: Of;
}

/** A part whose script is loaded when it is to be seen. Nothing stands in its place before. */
export function Later<Of extends object = object>({ load, of }: Props<Of>) {
  const Part = useSignal<FunctionComponent<Of> | null>(null);
  useSignalEffect(() => bring(load, (loaded) => { Part.value = loaded; }));
  return Part.value && <Part.value {...((of ?? {}) as Of)} />;
}
