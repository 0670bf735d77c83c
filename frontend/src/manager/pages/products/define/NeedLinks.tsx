import { format, t } from "../../../../text/views/products";
import { HERE, Linked } from "../../../parts/Linked";
import { addressOf, addressOfTransport } from "../../../views";
import { kept } from "./remove";

/** As many ways of a kind as somebody goes. */
const SHOWN = 10;

type Called = (typeof kept.value)[number]["orders"];

/** The ways to the orders and transports that keep products. Else it is not there. */
export function NeedLinks() {
  const orders = linksTo(kept.value.flatMap(({ orders }) => orders), addressOf);
  const transports = linksTo(kept.value.flatMap(({ transports }) => transports), addressOfTransport);
  if (orders.length + transports.length === 0) return null;
  return (
    <section class="bulk-bar card" aria-label={t("products.waysLabel")}>
      {orders.length > 0 && <p><Linked text={t("products.ways", { orders: places(orders) })} links={orders} /></p>}
      {transports.length > 0 && <p><Linked text={t("products.waysToTransports", { transports: places(transports) })} links={transports} /></p>}
    </section>
  );
}

/** Links to the first ones of these, each once. */
export function linksTo(called: Called, addressOf: (id: string) => string) {
  const texts = new Map(called.map(({ id, text }) => [id, text]));
  return [...texts].slice(0, SHOWN).map(([id, text]) => ({ href: addressOf(id), text, label: t("products.newTab", { order: text }) }));
}

const places = (links: readonly unknown[]): string => format.list(links.map(() => HERE));
