import { type Signal, useSignal, useSignalEffect } from "@preact/signals";
import { nowS } from "../../../stream/stream";
import { speakAlso } from "../../../text/speech";
import { format, t, tables } from "../../../text/views/paper";
import { problemText } from "../../problem-text";
import type { PageOf } from "../pages/paged";
import { drawn } from "./printing";
import { readWhole } from "./whole";

export interface Printing {
  readonly fetchAfter: (after: string) => Promise<PageOf<unknown>>;
  /** What is shown instead of the page while it is printed; null for the page. */
  readonly whole: Signal<PageOf<unknown> | null>;
}

/** The button, once it has its words. */
export async function load(): Promise<typeof PrintAll> {
  await speakAlso(tables);
  return PrintAll;
}

/** Reads all that the filter finds, shows it, and has the browser print that; Ctrl-P does the same. */
export function PrintAll({ fetchAfter, whole }: Printing) {
  const read = useSignal<number | null>(null);
  const failed = useSignal("");
  const printAll = async (): Promise<void> => {
    if (read.peek() !== null) return;
    read.value = 0;
    failed.value = "";
    try {
      whole.value = await readWhole(fetchAfter, (rows) => { read.value = rows; });
      await drawn();
      print();
    } catch (error) {
      failed.value = t("paper.failed", { reason: problemText(error) });
    } finally {
      whole.value = null;
      read.value = null;
    }
  };
  useSignalEffect(() => {
    const key = (event: KeyboardEvent): void => {
      if (!(event.ctrlKey || event.metaKey) || event.altKey || event.shiftKey || event.key.toLowerCase() !== "p") return;
      event.preventDefault();
      void printAll();
    };
    addEventListener("keydown", key);
    return () => { removeEventListener("keydown", key); };
  });
  const rows = whole.value;
  const told = { n: format.count(rows?.items.length ?? 0), at: format.when(nowS.value, 0) };
  return (
    <>
      <button type="button" class="button" title={t("paper.printTitle")} disabled={read.value !== null} onClick={() => void printAll()}>
        {read.value === null ? t("paper.print") : t("paper.reading", { n: format.count(read.value) })}
      </button>
      {failed.value !== "" && <span class="complaint" role="alert">{failed.value}</span>}
      <p class="paper-only">{rows === null ? t("paper.screen") : t(rows.next_cursor === null ? "paper.all" : "paper.first", told)}</p>
    </>
  );
}
