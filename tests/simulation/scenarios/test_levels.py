"""Bills of three levels, with kills and scrap: everything is delivered, and every piece is accounted for."""

from __future__ import annotations

import pytest

from dray_sim.scenarios.levels import levels


def held(orders: int) -> None:
    found = levels(1, orders)
    assert [check.name for check in found.checks if not check.held] == []
    assert found.checks, found.runs[0].invariants


def test_a_few_orders_of_three_levels_are_delivered_and_the_balance_closes() -> None:
    held(6)


@pytest.mark.campaign
def test_with_kills_orders_of_three_levels_are_delivered_and_the_balance_closes() -> None:
    held(30)
