/** Taking alerts on, by one's own name. */
import { signal } from "@preact/signals";
import { acknowledgeAlert } from "../../api/client";
import { t } from "../../text/manager";
import { problemText } from "../problem-text";

/** What became of the last try, where it failed. */
export const failed = signal("");
/** Those whose answer is awaited. */
export const taking = signal<ReadonlySet<string>>(new Set());

export async function take(id: string): Promise<void> {
  taking.value = new Set(taking.value).add(id);
  failed.value = "";
  try {
    await acknowledgeAlert(id);
  } catch (error) {
    failed.value = t("alerts.takeFailed", { reason: problemText(error) });
  } finally {
    const left = new Set(taking.value);
    left.delete(id);
    taking.value = left;
  }
}
