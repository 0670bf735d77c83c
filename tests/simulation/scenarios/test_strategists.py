"""Two strategists, one of which is killed every few minutes."""

from __future__ import annotations

import pytest
from msgspec.structs import replace

from dray.messages import Event
from dray.messages.fact import OrderAccepted, OrderTakenOver
from dray.messages.gate import OrderHeld
from dray.protocol.gate.order_holders import OrderHolders
from dray_sim.checks.broken import InvariantBroken
from dray_sim.checks.one_holder import OneHolderEach
from dray_sim.run.evidence import HELD
from dray_sim.run.site import Site
from dray_sim.run.stage import Shift, Stage, play, with_strategists
from dray_sim.scenarios.paper.laboratory import laboratory
from dray_sim.scenarios.strategists import strategists


def test_with_kills_every_order_is_begun_in_time_and_delivered_once() -> None:
    found = strategists(1, 0.75, 0.4)
    assert [run.invariants for run in found.runs] == [HELD, HELD]
    assert found.checks
    assert [check.name for check in found.checks if not check.held] == []


def test_any_scenario_is_played_with_as_many_strategists_as_are_asked_for() -> None:
    async def names(stage: Stage) -> tuple[str, ...]:
        return stage.factory.strategists

    def told(shift: Shift) -> tuple[str, ...] | None:
        return play(shift, laboratory(), 1, names).result

    with with_strategists(2):
        assert told(Shift("any", 0.0)) == ("strategist", "strategist2")
        assert told(Shift("alone", 0.0, strategists=1)) == ("strategist",)
    assert told(Shift("any", 0.0)) == ("strategist",)
    assert str(Site(strategists=2)) == "2 strategists"
    assert not Site(strategists=2).is_other


@pytest.mark.campaign
def test_for_eight_hours_every_order_is_begun_in_time_and_delivered_once() -> None:
    found = strategists(2)
    assert found.checks, [run.invariants for run in found.runs]
    assert [check.name for check in found.checks if not check.held] == []


def test_a_gate_that_lets_everybody_hold_an_order_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    def let(self: OrderHolders, strategist: str, order: str, epoch: int, over: int = 0) -> OrderHeld:
        known = self._orders.get(order)
        if known is not None:
            self._orders[order] = replace(known, holder=strategist)
        return claim(self, strategist, order, epoch, over)

    claim = OrderHolders.claim
    monkeypatch.setattr(OrderHolders, "claim", let)
    found = strategists(1, 0.75, 0.4)
    assert "invariant" in found.runs[1].invariants


def told(by: str, *facts: OrderAccepted | OrderTakenOver, check: OneHolderEach) -> None:
    for number, fact in enumerate(facts, 1):
        check.on_message(0.0, by, "", Event(by, 1, number, 0.0, fact))


def test_an_order_that_two_have_taken_is_seen() -> None:
    check = OneHolderEach()
    told("strategist", OrderAccepted("O1", ("G1",)), check=check)
    told("strategist2", OrderTakenOver("O1", 2, ("G1",)), check=check)
    with pytest.raises(InvariantBroken, match="which strategist2 holds"):
        told("strategist", OrderAccepted("O1", ("G1",)), check=check)


def test_an_order_that_is_taken_over_with_an_epoch_that_another_one_has_is_seen() -> None:
    check = OneHolderEach()
    told("strategist", OrderTakenOver("O1", 2, ("G1",)), check=check)
    with pytest.raises(InvariantBroken, match="with epoch 2"):
        told("strategist2", OrderTakenOver("O1", 2, ("G1",)), check=check)
