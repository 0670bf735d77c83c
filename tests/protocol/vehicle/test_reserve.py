"""Which vehicles of a fleet that is too large for its floor take no work that others can do."""

from __future__ import annotations

from typing import cast

import pytest
from atv1 import SETTLED_S, handing_over, last_beat, parked
from defaults import PLANT
from spoken import award

from dray.messages import HandoverAccepted
from dray.plant.spare_places import SparePlaces
from dray.protocol.vehicle.atv import Atv
from dray.protocol.vehicle.drivers.driver import Driver
from dray.protocol.vehicle.reserve import PAUSE_MAX_S, PAUSE_S, STAYS_S, Reserve
from dray_sim.plants.fleet_sizes import with_fleet
from dray_sim.plants.raster import draw_raster

IN, OUT = "in", "out"


@pytest.fixture
def reserve(monkeypatch: pytest.MonkeyPatch) -> Reserve:
    monkeypatch.setattr(SparePlaces, "is_reserve", lambda _self, node: node == IN)
    return Reserve(PLANT, "light")


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
    reserve = Reserve(plant, next(iter(plant.fleet.values())).type)
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


def test_a_slow_transport_pauses_its_vehicle_and_each_next_one_for_twice_as_long(reserve: Reserve) -> None:
    for number in range(6):
        reserve.end_work(0.3, number * 10_000.0)
        pause_s = min(2.0**number * PAUSE_S, PAUSE_MAX_S)
        assert reserve.is_member(number * 10_000.0 + pause_s - 1.0)
        assert not reserve.is_member(number * 10_000.0 + pause_s)


def test_a_transport_that_went_well_halves_the_next_pause_until_there_is_none(reserve: Reserve) -> None:
    reserve.end_work(0.3, 0.0)
    reserve.end_work(0.3, 1_000.0)
    reserve.end_work(0.9, 2_000.0)
    assert reserve.is_member(2_000.0 + PAUSE_S - 1.0)
    assert not reserve.is_member(2_000.0 + PAUSE_S)
    reserve.end_work(0.9, 3_000.0)
    assert not reserve.is_member(3_000.0)


def test_work_ends_a_pause_and_ways_that_tell_nothing_begin_none(reserve: Reserve) -> None:
    reserve.end_work(0.3, 0.0)
    reserve.take_work()
    assert not reserve.is_member(1.0)
    reserve.end_work(None, 2.0)
    assert not reserve.is_member(3.0)


def test_who_was_slow_on_the_roads_says_after_its_transport_that_it_is_in_the_reserve(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(Driver, "take_pace_frac", lambda _self: 0.3)
    rig = handing_over()
    assert not last_beat(rig).in_reserve
    rig.on_message("M8", HandoverAccepted(task="M8-1", epoch=1))
    assert last_beat(rig).in_reserve
    rig.run(rig.now_s + PAUSE_S + 10.0)
    assert not last_beat(rig).in_reserve


def test_a_small_fleet_never_pauses() -> None:
    few = Reserve(with_fleet(PLANT, 3), "light")
    few.end_work(0.1, 0.0)
    assert not few.is_member(1.0)


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
