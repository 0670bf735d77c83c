import { useSignal, useSignalEffect } from "@preact/signals";
import type { FunctionComponent } from "preact";
import { bring } from "../../../api/bring";
import { t } from "../../../text/manager";
import { PopButton } from "../../parts/PopButton";

interface Props {
  label: string;
  title: string;
  load: () => Promise<FunctionComponent>;
}

/** A small button on a card whose sheet is loaded when it is opened. */
export function SheetButton({ label, load, title }: Props) {
  const sheet = useSignal<FunctionComponent | null>(null);
  const failed = useSignal(false);
  const isOpen = useSignal(false);
  useSignalEffect(() => {
    if (!isOpen.value || sheet.peek()) return;
    return bring(load, (loaded) => { sheet.value = loaded; }, () => { failed.value = true; });
  });
  const Sheet = sheet.value;
  return (
    <PopButton
      icon="hand"
      label={label}
      title={title}
      onToggle={(opened) => { isOpen.value = opened; }}
    >
      {() => (Sheet ? <Sheet /> : <p role="status">{t(failed.value ? "view.notLoaded" : "view.loading")}</p>)}
    </PopButton>
  );
}
