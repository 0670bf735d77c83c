import { format, n, t } from "../../text/manager";
import { plant } from "../state";
import { makersOf, needsOf, quantityOf } from "./draft";
import { draft, outcome } from "./form";

/** As many as fit into a line or two. */
const MOST_NAMED = 6;

/** Who can make it, and what has to be brought for it (the plant's bill); after sending, what came of it. */
export function Feasible() {
  const file = plant.value;
  if (!file) return null;
  if (outcome.value) {
    const { good, text } = outcome.value;
    return <p class={`outcome outcome-${good ? "good" : "bad"}`}>{text}</p>;
  }
  const { product } = draft.value;
  const makers = makersOf(file, product);
  const needs = needsOf(file, product, quantityOf(draft.value) ?? 0);
  const named = makers.slice(0, MOST_NAMED).map(({ id }) => id);
  const others = makers.length - named.length;
  const machines = format.list(others > 0 ? [...named, n("publish.others", others)] : named);
  const cycle = format.duration(Math.min(...makers.map(({ cycleS }) => cycleS)));
  return (
    <>
      <p>{makers.length === 0 ? t("publish.nobody") : t("publish.machines", { machines, cycle })}</p>
      <ul>
        {needs.map(({ name, pieces, lots }) => (
          <li key={name}>
            <b>{format.count(pieces)}</b> {name} <span class="faint">{n("publish.lots", lots, format.count(lots))}</span>
          </li>
        ))}
      </ul>
    </>
  );
}
