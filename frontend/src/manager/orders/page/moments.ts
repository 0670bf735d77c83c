/** What happened to an order, in words. */
import type { components } from "../../../api/types";
import { format, t, word } from "../../../text/views/order";
import { names, placeOf } from "../../state";
import type { Transport } from "./lanes";

export type Moment = components["schemas"]["MomentView"];
export type Wanted = "all" | "transports" | "problems";

const OF_TRANSPORTS: ReadonlySet<Moment["kind"]> = new Set(["won", "fetched", "handed_over", "took_over", "announced_anew", "arrived"]);
const PROBLEMS: ReadonlySet<Moment["kind"]> = new Set(["moved", "waits", "took_over", "announced_anew", "withdrawn", "dropped", "called_off", "cancelled", "started_anew"]);

export function isWanted(moment: Moment, wanted: Wanted): boolean {
  if (wanted === "transports") return OF_TRANSPORTS.has(moment.kind);
  return wanted === "all" || PROBLEMS.has(moment.kind);
}

export function isProblem(moment: Moment): boolean {
  return PROBLEMS.has(moment.kind);
}

export { placeOf };

/** @param thing what people call it, where it has no master data */
export function loadOf(item: string, quantity: number, thing = ""): string {
  return thing || `${format.count(quantity)} ${names.value(item)}`;
}

export function momentText(moment: Moment): string {
  const text = t(`moment.${moment.kind}`, {
    agent: moment.agent,
    other: placeOf(moment.other),
    load: loadOf(moment.item, moment.quantity, moment.thing),
    item: moment.thing || names.value(moment.item),
  });
  if (moment.reason === "") return text;
  const reason = word("reason.why", moment.reason);
  return moment.silent_s === null
    ? t("moment.because", { text, reason })
    : t("moment.becauseSilent", { text, reason, age: format.age(moment.silent_s) });
}

/** Who carried it and who carries it now, in one sentence or two; what was on another day says its day. */
export function transportText(transport: Transport, nowS: number): string {
  const told = transport.legs.map((leg) => {
    if (leg.replaced !== "") {
      return t("leg.replaced", { carrier: leg.carrier, at: format.when(leg.until_at_s ?? leg.since_at_s, nowS), reason: word("reason.why", leg.replaced) });
    }
    if (leg.until_at_s !== null) {
      const key = transport.outcome === "" || transport.outcome === "delivered" ? "leg.done" : "leg.ended";
      return t(key, { carrier: leg.carrier, at: format.when(leg.until_at_s, nowS), to: placeOf(transport.destination) });
    }
    if (leg.aboard_at_s !== null) return t("leg.carries", { carrier: leg.carrier, at: format.when(leg.aboard_at_s, nowS) });
    return t("leg.fetches", { carrier: leg.carrier, at: format.when(leg.since_at_s, nowS), from: placeOf(transport.source) });
  });
  if (transport.outcome === "withdrawn" || transport.outcome === "started_anew") told.push(t(`leg.${transport.outcome}`));
  else if (transport.closed_at_s === null && transport.legs.every((leg) => leg.until_at_s !== null)) told.push(t("leg.nobody"));
  return told.join(" ");
}
