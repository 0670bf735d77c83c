import { useLayoutEffect, useRef } from "preact/hooks";
import type { OrderView } from "../../../api/types";
import { world } from "../../../stream/stream";
import { t } from "../../../text/views/order";
import { keepFocus } from "../../parts/keep-focus";
import { Named } from "../Named";
import { moved } from "../page/change-costs";
import { inOrder } from "../progress";
import { isQueued, move, moving, propose, proposed } from "../Queue";

/** What a move in the queue costs whom, before it is saved. Else it is not there. */
export function MoveBar() {
  const wanted = proposed.value;
  const queue = inOrder(world.value?.orders.values() ?? []).filter(isQueued);
  const order = queue.find(({ id }) => id === wanted?.order);
  const before = queue.find(({ id }) => id === wanted?.before);
  if (order === undefined || before === undefined) return null;
  return <Asked key={order.id} order={order} before={before} queue={queue} />;
}

interface AskedProps {
  readonly order: OrderView;
  readonly before: OrderView;
  readonly queue: readonly OrderView[];
}

function Asked({ before, order, queue }: AskedProps) {
  const yes = useRef<HTMLButtonElement>(null);
  useLayoutEffect(() => {
    const from = document.activeElement;
    const place = from?.closest("tr") ?? null;
    return () => { keepFocus(place, from); };
  }, []);
  // The button of one place further may be gone with the last place.
  useLayoutEffect(() => { yes.current?.focus(); }, [before.id]);
  const { letsPass, passes } = moved(order, before, queue);
  const others = queue.filter(({ id }) => id !== order.id);
  const ahead = others[others.indexOf(before) - 1];
  const leave = () => { proposed.value = null; };
  return (
    <section class="bulk-bar card" aria-label={t("queue.label")} onKeyDown={(event) => { if (event.key === "Escape") leave(); }}>
      <span role="status">
        <b>{t("queue.asked", { order: order.reference ?? order.id, before: before.reference ?? before.id })}</b>{" "}
        {passes.length > 0 ? <Named text="change.passes" orders={passes} /> : letsPass.length > 0 ? <Named text="queue.letsPass" orders={letsPass} /> : t("change.passesNobody")}
      </span>
      <button ref={yes} type="button" class="button small primary" disabled={moving.value} onClick={() => void move()}>
        {t("queue.move")}
      </button>
      {ahead !== undefined && (
        <button type="button" class="button small" disabled={moving.value} onClick={() => { propose(order.id, ahead.id); }}>
          {t("queue.further")}
        </button>
      )}
      <button type="button" class="button small" disabled={moving.value} onClick={leave}>
        {t("queue.leave")}
      </button>
    </section>
  );
}
