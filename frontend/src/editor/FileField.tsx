import { t } from "../text/editor";

/** A field for a file. A browser's own button speaks the browser's language, whatever somebody has chosen here. */
export function FileField({ accept, disabled, label, onFile }: { accept: string; disabled: boolean; label: string; onFile: (file: File) => void }) {
  return (
    <label class="ed-file">{label}{" "}
      <span class="button">{t("file.choose")}</span>
      <input type="file" class="unseen" accept={accept} disabled={disabled} onChange={(event) => {
        const input = event.currentTarget;
        const file = input.files?.[0];
        if (file) onFile(file);
        // The same file, corrected, may be chosen again.
        input.value = "";
      }} />
    </label>
  );
}
