import type { OrderView } from "../../api/types";
import { format, t } from "../../text/views/order";
import { HERE, Linked } from "../parts/Linked";
import { addressOf } from "../views";

/** As many are named. */
const NAMED = 3;

/** Whom a change concerns, with the ways to the first of them. */
export function Named({ orders, text }: { orders: readonly OrderView[]; text: "change.passes" | "queue.letsPass" }) {
  const first = orders.slice(0, NAMED);
  const links = first.map(({ id, reference }) => {
    const name = reference ?? id;
    return { href: addressOf(id), text: name, label: t("change.newTab", { order: name }) };
  });
  return <Linked text={t(orders.length === 1 ? `${text}.one` : `${text}.other`, { orders: format.list(first.map(() => HERE)), n: format.count(orders.length) })} links={links} />;
}
