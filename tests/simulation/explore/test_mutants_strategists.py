"""The search finds what goes wrong where several strategists share the orders, with a safeguard taken out (see `test_mutants`)."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import pytest
from gate_mutants import with_a_gate_that_lets_everybody_hold_an_order
from mutants import Find

from dray.messages import OrderReleased
from dray.messages.gate import GoalHeld
from dray.protocol.strategist.order_book import OrderBook
from dray.protocol.strategist.order_in_work import OrderInWork
from dray_sim.explore.run import draw

Mutant = Callable[[pytest.MonkeyPatch], None]


def that_takes_over_without_the_count(patch: pytest.MonkeyPatch) -> None:
    """An order that is taken over begins anew: what has arrived of it counts for nothing."""
    take_over = OrderBook.take_over

    def begin(
        self: OrderBook, message: OrderReleased, _arrived: Sequence[int], _goals: Sequence[GoalHeld]
    ) -> OrderInWork:
        return take_over(self, message, (), ())

    patch.setattr(OrderBook, "take_over", begin)


MUTANTS = [
    pytest.param(with_a_gate_that_lets_everybody_hold_an_order, "invariant 26", id="held-twice"),
    pytest.param(that_takes_over_without_the_count, "invariant 4", id="made-twice"),
]


@pytest.mark.campaign
@pytest.mark.parametrize(("mutant", "finding"), MUTANTS)
def test_the_search_finds_a_mutant(mutant: Mutant, finding: str, find: Find) -> None:
    find(mutant, lambda seed: draw(seed, "strategists"), 0, finding)
