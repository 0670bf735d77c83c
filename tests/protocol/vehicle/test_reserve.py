"""Which vehicles of a fleet that is too large for its floor take no work that others can do."""

from __future__ import annotations

from typing import cast

import pytest
from atv1 import SETTLED_S, last_beat, parked
from defaults import PLANT
from spoken import award

from dray.plant.spare_places import SparePlaces
from dray.protocol.vehicle.atv import Atv
from dray.protocol.vehicle.reserve import STAYS_S, Reserve
from dray_sim.plants.fleet_sizes import with_fleet
from dray_sim.plants.raster import draw_raster

IN, OUT = "in", "out"


@pytest.fixture
def reserve(monkeypatch: pytest.MonkeyPatch) -> Reserve:
    monkeypatch.setattr(SparePlaces, "is_reserve", lambda _self, node: node == IN)
    return Reserve(PLANT)


def test_a_vehicle_belongs_to_the_reserve_only_after_it_has_stood_there(reserve: Reserve) -> None:
    assert not reserve.is_member(0.0)
    reserve.stand(OUT, 0.0)
    assert not reserve.is_member(1.0)
    reserve.stand(IN, 2.0)
    assert reserve.is_member(2.0)
    assert reserve.is_member(100.0 * STAYS_S)


def test_standing_elsewhere_counts_from_the_last_place(reserve: Reserve) -> None:
    reserve.stand(IN, 0.0)
    for place in range(3):
        reserve.leave(place * STAYS_S)
        reserve.stand(OUT, place * STAYS_S + 1.0)
        assert reserve.is_member((place + 1) * STAYS_S)
    assert not reserve.is_member(3 * STAYS_S + 1.0)


def test_who_has_stood_elsewhere_for_the_time_is_at_work_also_after_it_leaves(reserve: Reserve) -> None:
    reserve.stand(IN, 0.0)
    reserve.leave(10.0)
    reserve.stand(OUT, 20.0)
    reserve.leave(20.0 + STAYS_S)
    assert not reserve.is_member(20.0 + STAYS_S)
    reserve.stand(OUT, 40.0 + STAYS_S)
    assert not reserve.is_member(40.0 + STAYS_S)


def test_who_comes_back_belongs_to_the_reserve_as_before(reserve: Reserve) -> None:
    reserve.stand(IN, 0.0)
    reserve.leave(10.0)
    reserve.stand(OUT, 20.0)
    reserve.leave(30.0)
    reserve.stand(IN, 40.0)
    assert reserve.is_member(40.0 + 2 * STAYS_S)


def test_where_vehicles_wait_in_the_way_of_others_who_leaves_the_reserve_is_at_work() -> None:
    plant = with_fleet(draw_raster(17), 28)
    spare = plant.spare_places
    assert spare.others
    reserve = Reserve(plant)
    reserve.stand(spare.reserve[0], 0.0)
    assert reserve.is_member(1.0)
    reserve.leave(2.0)
    assert not reserve.is_member(2.0)
    reserve.stand(spare.reserve[0], 3.0)
    reserve.stand(spare.clear[0], 4.0)
    assert not reserve.is_member(4.0)


def test_work_ends_the_membership(reserve: Reserve) -> None:
    reserve.stand(IN, 0.0)
    reserve.leave(5.0)
    reserve.take_work()
    assert not reserve.is_member(5.0)
    reserve.stand(OUT, 6.0)
    assert not reserve.is_member(6.0)


def test_who_makes_room_stays_in_the_reserve_and_says_so_and_who_takes_work_does_not(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(SparePlaces, "is_reserve", lambda _self, node: node == PLANT.node_of("P3"))
    rig = parked()
    agent = cast(Atv, rig.agent)
    rig.run(SETTLED_S)
    assert last_beat(rig).in_reserve
    agent.note_makes_room(rig.now_s)
    assert agent.is_reserve(rig.now_s)
    rig.on_message("M8", award())
    assert agent.is_busy
    assert not agent.is_reserve(rig.now_s)
    assert not last_beat(rig).in_reserve
