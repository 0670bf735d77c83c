"""Invariant 26: one strategist at a time holds an order, and another one only with a higher epoch."""

from __future__ import annotations

from dray.messages import Event, Message
from dray.messages.fact import OrderAccepted, OrderDropped, OrderFulfilled, OrderTakenOver
from dray_sim.checks.broken import InvariantBroken


class OneHolderEach:
    """Listens to the strategists' own messages; ended orders are forgotten."""

    hears = (Event,)

    def __init__(self) -> None:
        self._held: dict[str, tuple[str, int]] = {}
        """Holder and epoch, by order."""

    def on_message(self, at_s: float, sender: str, _address: str, message: Message) -> None:
        """Note one utterance.

        Raises:
            InvariantBroken: two hold an order.
        """
        if type(message) is not Event:
            return
        fact = message.fact
        if type(fact) is OrderAccepted:
            holder, epoch = self._held.setdefault(fact.order, (sender, 1))
            if holder != sender:
                seen = f"{sender} has taken {fact.order}, which {holder} holds with epoch {epoch}"
                raise InvariantBroken(26, at_s, seen)
        elif type(fact) is OrderTakenOver:
            holder, epoch = self._held.get(fact.order, ("", 0))
            if fact.epoch < epoch or (fact.epoch == epoch and holder != sender):
                seen = f"{sender} has taken {fact.order} over with epoch {fact.epoch}; {holder} holds it with {epoch}"
                raise InvariantBroken(26, at_s, seen)
            self._held[fact.order] = (sender, fact.epoch)
        elif type(fact) is OrderFulfilled or type(fact) is OrderDropped:
            self._held.pop(fact.order, None)
