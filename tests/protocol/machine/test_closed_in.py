"""A machine to which people have closed all ways offers what is due before one opens, and takes nothing that is."""

from __future__ import annotations

import pytest
from closed import closure, closures
from defaults import PLANT
from effects import facts, published, sent
from m7 import m7
from msgspec import UNSET
from msgspec.structs import replace
from rigs import MachineRig
from spoken import announcement, production

from dray.messages import Bid, MachineHeartbeat
from dray.messages.base import COUNT_MAX
from dray.messages.fact import BidRefused

DOCK = PLANT.node_of("M7")
DUE_S = 3600.0
"""The goal of `m7` is due then."""


def shut(rig: MachineRig, number: int, until_s: float | None) -> None:
    """A manager closes the dock."""
    rig.on_message("gateway", closures(number, closure("C1", node=DOCK, until_s=until_s)))


def offered(rig: MachineRig) -> object:
    """What the newest heartbeat says of its only goal."""
    rig.run(rig.now_s + 0.001)
    [goal] = published(rig.all, MachineHeartbeat)[-1].goals
    return goal.offered


@pytest.mark.parametrize(("until_s", "offers"), [(None, True), (DUE_S + 1.0, True), (DUE_S - 1.0, UNSET)])
def test_what_is_due_before_a_way_opens_is_offered(until_s: float | None, offers: object) -> None:
    rig = m7(goal=24)
    shut(rig, 1, until_s)
    assert offered(rig) is offers


def test_what_was_offered_and_nobody_has_taken_is_made_here_when_a_way_opens_again() -> None:
    rig = m7(goal=24)
    shut(rig, 1, None)
    assert offered(rig) is True
    rig.cycle()
    assert not rig.is_cycling
    rig.on_message("gateway", closures(2))
    assert offered(rig) is UNSET
    assert rig.is_cycling


def test_a_closure_that_leaves_a_way_changes_nothing() -> None:
    rig = m7(goal=24)
    other = PLANT.node_of("M8")
    rig.on_message("gateway", closures(1, closure("C1", node=other)))
    assert offered(rig) is UNSET


def test_nothing_is_taken_that_is_due_before_a_way_opens() -> None:
    rig = m7()
    shut(rig, 1, DUE_S)
    rig.on_message("strategist", announcement(task="G7", work=production(quantity=8), deadline_s=DUE_S - 1.0))
    assert not sent(rig.all, Bid)
    assert [each.detail for each in facts(rig.all, BidRefused)] == ["what is closed leaves no way to it"]
    rig.on_message("strategist", announcement(task="G8", work=production(quantity=8), deadline_s=DUE_S + 1.0))
    assert [bid.task for bid in sent(rig.all, Bid)] == ["G8"]


def test_a_list_that_no_person_has_signed_closes_no_dock_and_shuts_out_no_later_list() -> None:
    """A thief of a gateway's certificate has sent it."""
    rig = m7(goal=24)
    shut(rig, 1, None)
    assert offered(rig) is True
    rig.cycle()
    rig.on_message("gateway", replace(closures(COUNT_MAX), signature=b""))
    assert not rig.is_cycling
    rig.on_message("gateway", closures(2))
    assert offered(rig) is UNSET
    assert rig.is_cycling
