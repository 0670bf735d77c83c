/** A file of orders: looked through first, placed only when nothing is wrong with it. */
import { computed, signal } from "@preact/signals";
import { importOrders, newKey } from "../../api/client";
import { type FileBody, fileBody } from "../../api/file-body";
import type { ImportAnswer } from "../../api/types";
import { t } from "../../text/views/order";
import { problemText } from "../problem-text";

interface Chosen {
  readonly name: string;
  readonly body: FileBody;
  /** The same for every try: however often it is sent, it is placed once. */
  readonly key: string;
}

const chosen = signal<Chosen | null>(null);

/** What the gateway says is in the file; null before it was asked. */
export const found = signal<ImportAnswer | null>(null);
export const busy = signal(false);
export const failed = signal("");
export const placed = signal<number | null>(null);
export const fileName = computed(() => chosen.value?.name ?? "");
/** Orders that could be placed now. */
export const ready = computed(() => {
  const file = found.value;
  return file?.faults.length === 0 && placed.value === null ? file.orders.length : 0;
});

export async function choose(file: File | undefined): Promise<void> {
  chosen.value = found.value = placed.value = null;
  failed.value = "";
  if (!file) return;
  chosen.value = { name: file.name, body: await fileBody(file), key: newKey() };
  await send(true);
}

export async function place(): Promise<void> {
  await send(false);
}

async function send(dryRun: boolean): Promise<void> {
  const file = chosen.value;
  if (!file || busy.value) return;
  busy.value = true;
  failed.value = "";
  try {
    const answer = await importOrders(file.body, dryRun, file.key);
    if (dryRun) found.value = answer;
    else placed.value = answer.orders.length;
  } catch (error) {
    failed.value = t("import.failed", { reason: problemText(error) });
  } finally {
    busy.value = false;
  }
}
