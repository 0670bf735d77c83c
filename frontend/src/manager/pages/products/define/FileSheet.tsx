import { computed, signal } from "@preact/signals";
import { type FileBody, fileBody } from "../../../../api/file-body";
import { importProducts } from "../../../../api/products";
import type { components } from "../../../../api/types";
import { format, n, t } from "../../../../text/views/products";
import { FileChoice } from "../../../parts/FileChoice";
import { RowFaults } from "../../../parts/RowFaults";
import { Sheet } from "../../../parts/Sheet";
import { plantAsked } from "../../../plant-asked";
import { problemText } from "../../../problem-text";

const ID = "products-file";

const chosen = signal<{ name: string; body: FileBody } | null>(null);
/** What the gateway says is in the file; null before it was asked. */
const found = signal<components["schemas"]["ProductsAnswer"] | null>(null);
const taken = signal(false);
const busy = signal(false);
const failed = signal("");
/** Products of the file that would be otherwise than they are. */
const news = computed(() => (found.value?.products ?? []).filter(({ becomes }) => becomes !== "unchanged"));

export function FileButton() {
  return (
    <button type="button" class="button" popovertarget={ID}>
      {t("products.import")}
    </button>
  );
}

async function ask(dryRun: boolean): Promise<boolean> {
  if (!chosen.value || busy.value) return false;
  busy.value = true;
  failed.value = "";
  try {
    found.value = await importProducts(chosen.value.body, dryRun);
    taken.value = !dryRun;
    if (!dryRun) void plantAsked.now();
    return true;
  } catch (error) {
    failed.value = t("products.failed", { reason: problemText(error) });
    return false;
  } finally {
    busy.value = false;
  }
}

async function choose(file: File | undefined): Promise<void> {
  chosen.value = found.value = null;
  taken.value = false;
  if (!file) return;
  chosen.value = { name: file.name, body: await fileBody(file) };
  await ask(true);
}

/** Products of a spreadsheet: first looked through, with what is wrong in which row; then all of them, or none. */
export function FileSheet({ onTaken }: { onTaken: () => void }) {
  const faults = found.value?.faults ?? [];
  const hints = taken.value ? [] : (found.value?.hints ?? []);
  const ready = found.value !== null && faults.length === 0 && !taken.value;
  return (
    <Sheet id={ID} title={t("products.import")}>
      <p class="muted">{t("products.importHint")}</p>
      <FileChoice name={chosen.value?.name ?? ""} onChosen={(file) => void choose(file)} />
      <div role="status">
        {failed.value !== "" && <p class="complaint">{failed.value}</p>}
        {taken.value && <p class="outcome-good">{n("products.taken", news.value.length, format.count(news.value.length))}</p>}
        {ready && <p>{n("products.ready", news.value.length, format.count(news.value.length))}</p>}
        {faults.length > 0 && <p class="complaint">{n("import.faults", faults.length)}</p>}
      </div>
      <RowFaults faults={faults} />
      {hints.length > 0 && <p>{n("import.hints", hints.length)}</p>}
      <RowFaults faults={hints} />
      {ready && news.value.length > 0 && (
        <p>
          <button
            type="button"
            class="button primary"
            disabled={busy.value}
            onClick={() => void ask(false).then((done) => { if (done) onTaken(); })}
          >
            {t("products.takeFile")}
          </button>
        </p>
      )}
    </Sheet>
  );
}
