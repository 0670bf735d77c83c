import { useSignal } from "@preact/signals";
import { isCutOff } from "../../../../parts/Carrying";
import { format, n, t } from "../../../../text/views/products";
import { Sure } from "../../../parts/Sure";
import { type Definition, forget, kept, removeAll, removed, removing, ticked } from "./remove";

/** As many reasons as somebody reads. */
const SHOWN = 10;

/** What can be done to the products whose box is ticked, and what came of it. Else it is not there. */
export function RemoveBar({ definitions, onRemoved }: { definitions: readonly Definition[]; onRemoved: () => void }) {
  const asking = useSignal(false);
  const chosen = definitions.filter(({ id }) => ticked.value.has(id));
  const stay = kept.value;
  if (chosen.length === 0 && stay.length === 0 && removed.value === null) return null;
  const many = format.count(chosen.length);
  const cutOff = isCutOff();
  return (
    <section class="bulk-bar card" aria-label={t("products.removeLabel")}>
      {chosen.length > 0 && <b>{n("products.ticked", chosen.length, many)}</b>}
      {removing.value && <span role="status">{t("products.removing")}</span>}
      {!removing.value && chosen.length > 0 && !asking.value && (
        <button type="button" class="button small" disabled={cutOff} aria-describedby={cutOff ? "products-cut-off" : undefined} onClick={() => (asking.value = true)}>
          {n("products.removeTicked", chosen.length, many)}
        </button>
      )}
      {!removing.value && chosen.length > 0 && asking.value && (
        <Sure
          asked={n("products.removeSure", chosen.length, chosen.length === 1 ? (chosen[0]?.name ?? "") : many)}
          no={t("products.removeNot")}
          yes={n("products.removeDo", chosen.length, many)}
          busy={false}
          blocked={cutOff}
          onNo={() => (asking.value = false)}
          onYes={() => {
            asking.value = false;
            void removeAll(chosen).then(onRemoved);
          }}
        />
      )}
      {cutOff && chosen.length > 0 && <span id="products-cut-off" class="muted" role="status">{t("products.cutOff")}</span>}
      {!removing.value && removed.value !== null && <span role="status" class="outcome-good">{n("products.removed", removed.value, format.count(removed.value))}</span>}
      {!removing.value && !asking.value && (
        <button type="button" class="button small" onClick={forget}>
          {t(chosen.length > 0 ? "products.tickNone" : "products.dismiss")}
        </button>
      )}
      {stay.length > 0 && (
        <div role="alert">
          <ul class="complaint">
            {stay.slice(0, SHOWN).map(({ name, reason }) => (
              <li key={name}>{t("products.stays", { name, reason })}</li>
            ))}
            {stay.length > SHOWN && <li>{n("products.moreStay", stay.length - SHOWN, format.count(stay.length - SHOWN))}</li>}
          </ul>
        </div>
      )}
    </section>
  );
}
