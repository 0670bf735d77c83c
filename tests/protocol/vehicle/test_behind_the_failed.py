"""A vehicle that takes over from one that stands in the way to the load: it does not drive up behind it, as long as others have the load."""

from __future__ import annotations

import pytest
from atv1 import parked
from defaults import PLANT
from effects import published, sent
from placing import TRAFFIC, answer
from rigs import VehicleRig
from spoken import award, transport
from watches import beat, claims

from dray.messages import AtvStatus, HelpWanted, ObstacleSeen, Phase, Reason, Resigned, Role
from dray.messages.heartbeat import FloorBrief
from dray.protocol.vehicle.atv import Atv

DOCK = PLANT.node_of("S3")
PLACE = TRAFFIC.places.place_of(DOCK)


def taken_over(*holds: str, status: AtvStatus = AtvStatus.ERROR, **work: object) -> VehicleRig:
    """ATV1 has taken over from ATV2, which has told what it holds, and is not waited for."""
    rig = parked(traffic=TRAFFIC)
    answer(rig)
    rig.on_message("M8", award(role=Role.SECONDARY, primary="ATV2", work=transport(**work)))
    late = HelpWanted(until_s=rig.now_s)
    beat(rig, 1, phase=Phase.CARRYING, status=status, help=late, floor=FloorBrief(holds=holds))
    rig.run(rig.now_s + 0.1)
    assert claims(rig)
    return rig


def test_it_tells_of_it_and_gives_back_what_others_have_too() -> None:
    rig = taken_over(PLACE)
    [resigned] = sent(rig.all, Resigned, to="M8")
    assert (resigned.epoch, resigned.reason, resigned.detail, resigned.short) == (
        2,
        Reason.WAY_BLOCKED,
        "ATV2",
        "S3",
    )
    told = {(seen.start, seen.end) for seen in published(rig.all, ObstacleSeen)}
    assert told == set(TRAFFIC.places.entries(PLACE))


def test_what_is_only_to_be_had_there_it_fetches_all_the_same() -> None:
    rig = taken_over(PLACE, item="pump-p3", quantity=24, sources=("S3",), destination="DELIVERY")
    assert not sent(rig.all, Resigned, to="M8")


@pytest.mark.parametrize("holds", [(), (TRAFFIC.places.place_of(PLANT.node_of("S8")),)])
def test_one_that_stands_elsewhere_is_nothing_to_it(holds: tuple[str, ...]) -> None:
    rig = taken_over(*holds)
    assert not sent(rig.all, Resigned, to="M8")
    assert not published(rig.all, ObstacleSeen)


def test_one_that_can_move_is_no_obstacle() -> None:
    assert not published(taken_over(PLACE, status=AtvStatus.WORKING).all, ObstacleSeen)


def test_without_right_of_way_nobody_is_in_the_way() -> None:
    rig = parked()
    rig.on_message("M8", award(role=Role.SECONDARY, primary="ATV2"))
    late = HelpWanted(until_s=rig.now_s)
    beat(rig, 1, phase=Phase.CARRYING, status=AtvStatus.ERROR, help=late, floor=FloorBrief(holds=(PLACE,)))
    rig.run(rig.now_s + 0.1)
    assert claims(rig)
    assert isinstance(rig.agent, Atv)
    assert not rig.agent.floor.obstructed
    assert not sent(rig.all, Resigned, to="M8")
