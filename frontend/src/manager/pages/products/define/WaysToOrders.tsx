import { format, t } from "../../../../text/views/products";
import { HERE, Linked } from "../../../parts/Linked";
import { addressOf } from "../../../views";
import { kept } from "./remove";

/** As many ways as somebody goes. */
const SHOWN = 10;

/** The ways to the orders that keep products. Else it is not there. */
export function WaysToOrders() {
  const orders = new Map(kept.value.flatMap(({ orders }) => orders.map(({ id, text }) => [id, text])));
  const links = [...orders].slice(0, SHOWN).map(([id, text]) => ({ href: addressOf(id), text, label: t("products.newTab", { order: text }) }));
  if (links.length === 0) return null;
  return (
    <section class="bulk-bar card" aria-label={t("products.waysLabel")}>
      <p>
        <Linked text={t("products.ways", { orders: format.list(links.map(() => HERE)) })} links={links} />
      </p>
    </section>
  );
}
