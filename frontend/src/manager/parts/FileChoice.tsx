import { t } from "../../text/manager";

/** A button that chooses a spreadsheet, and the name of the one that was chosen. */
export function FileChoice({ name, onChosen }: { name: string; onChosen: (file: File | undefined) => void }) {
  return (
    <p>
      <label class="button import-file">
        {t("import.choose")}
        <input
          type="file"
          accept=".csv,text/csv"
          onChange={(event) => {
            const input = event.currentTarget;
            onChosen(input.files?.[0]);
            // The same file, corrected, may be chosen again.
            input.value = "";
          }}
        />
      </label>{" "}
      {name}
    </p>
  );
}
