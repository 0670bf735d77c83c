import { format, n, t } from "../../text";
import { plant } from "../state";
import { makersOf, needsOf, quantityOf } from "./draft";
import { draft } from "./form";

/** Who can make it, and what has to be brought for it: from the plant's own bill of material. */
export function Feasible() {
  const file = plant.value;
  if (!file) return null;
  const { product } = draft.value;
  const makers = makersOf(file, product);
  const needs = needsOf(file, product, quantityOf(draft.value) ?? 0);
  const machines = format.list(makers.map(({ id }) => id));
  const cycle = format.duration(Math.min(...makers.map(({ cycleS }) => cycleS)));
  return (
    <div class="feasible">
      <p>{makers.length === 0 ? t("publish.nobody") : t("publish.machines", { machines, cycle })}</p>
      <ul>
        {needs.map(({ name, pieces, lots }) => (
          <li key={name}>
            <span>{name}</span>
            <span class="num">{format.count(pieces)}</span>
            <span class="num faint">{n("publish.lots", lots, format.count(lots))}</span>
          </li>
        ))}
      </ul>
    </div>
  );
}
