"""A gate that is broken on purpose, for properties and for the search."""

from __future__ import annotations

import pytest
from msgspec.structs import replace

from dray.messages.gate import OrderHeld
from dray.protocol.gate.order_holders import OrderHolders


def with_a_gate_that_lets_everybody_hold_an_order(patch: pytest.MonkeyPatch) -> None:
    """Whoever asks holds an order, with the epoch that another one has."""
    claim = OrderHolders.claim

    def let(self: OrderHolders, strategist: str, order: str, epoch: int, over: int = 0) -> OrderHeld:
        if (known := self._orders.get(order)) is not None:
            self._orders[order] = replace(known, holder=strategist)
        return claim(self, strategist, order, epoch, over)

    patch.setattr(OrderHolders, "claim", let)
