"""A vehicle's next life, and a body that has not heard of it yet: what was held is held until the body obeys."""

from __future__ import annotations

import pytest
from rights_of_way import right_of_way

from dray.body import Drive, Hold
from dray.messages import HoldsAsked, PlaceConfirmed, PlaceGranted, PlaceRequested
from dray.messages.floor.traffic import PlaceReservation
from dray.plant import load_plant
from dray.protocol.runtime.events import Instruct, Send
from dray.protocol.runtime.life import Life
from dray.protocol.traffic.traffic_map import TrafficMap
from dray_sim.bodies.floor import Floor
from dray_sim.clock.loop import JUMP, clock, run

PLANT = load_plant("single-track")
TRAFFIC = TrafficMap(PLANT)
TYPE = next(iter(PLANT.vehicle_types))
LIFE = 2


class NewLife:
    """The right of way of a vehicle's second life, and what it has said and instructed."""

    def __init__(self, node: str, next_node: str = "", *, drives_beyond: bool) -> None:
        self.life = Life()
        self.out = self.life.effects
        self.row = right_of_way(PLANT, TRAFFIC, self.life, node, next_node, atv="ATV1", incarnation=LIFE)
        self.row.take_control(0.0, drives_beyond=drives_beyond)
        self.row.start(0.0)

    @property
    def drives(self) -> list[Drive]:
        return [
            effect.instruction
            for effect in self.life.effects
            if isinstance(effect, Instruct) and isinstance(effect.instruction, Drive)
        ]

    def request(self, district: str) -> PlaceRequested:
        """The newest one."""
        return [
            effect.message
            for effect in self.life.effects
            if isinstance(effect, Send)
            and isinstance(effect.message, PlaceRequested)
            and effect.message.district == district
        ][-1]

    def regrant(self, *places: str) -> None:
        """The tables grant anew what the first life held; all of it in the districts of these places."""
        for district in {TRAFFIC.places.district_of[place] for place in places}:
            lines = tuple(
                PlaceReservation(place=place, number=7)
                for place in places
                if TRAFFIC.places.district_of[place] == district
            )
            replica, copy = TRAFFIC.places.replicas_of[district][:2]
            seq = self.request(district).seq
            granted = PlaceGranted(district=district, epoch=0, life=LIFE, upto=seq, grants=lines)
            confirmed = PlaceConfirmed(district=district, epoch=0, grants=lines)
            self.row.on_confirmed(copy, confirmed, 0.1)
            self.row.on_granted(replica, granted, 0.1)
            self.row.on_holds_asked(copy, HoldsAsked(district=district, epoch=0), 0.1)


def test_a_new_life_holds_what_the_body_may_still_drive_into_until_the_body_obeys() -> None:
    life = NewLife("b3", "m4-lane", drives_beyond=True)
    district = TRAFFIC.places.district_of["c3"]
    life.regrant("b3", "m4-lane", "c3")
    assert set(life.row.way.held) == {"b3", "m4-lane", "c3"}
    assert "c3" in life.request(district).holds or life.request(district).seen < 7
    (drive,) = life.drives
    life.row.on_reached(drive.order, 0, 1.0)
    assert "c3" not in life.row.way.held
    assert "c3" not in life.request(district).holds
    assert life.request(district).seen == 7


def test_a_report_of_an_earlier_life_shows_no_obedience() -> None:
    life = NewLife("b3", "m4-lane", drives_beyond=True)
    life.regrant("b3", "m4-lane", "c3")
    life.row.on_reached(life.drives[0].order + 1000, 0, 1.0)
    assert "c3" in life.row.way.held


def test_a_body_that_goes_no_farther_lets_the_rest_be_given_back_at_once() -> None:
    life = NewLife("b3", "m4-lane", drives_beyond=False)
    life.regrant("b3", "m4-lane", "c3")
    assert "c3" not in life.row.way.held


def test_a_body_that_stands_with_more_to_drive_is_told_to_end_its_way() -> None:
    life = NewLife("b3", drives_beyond=True)
    life.regrant("b3", "m4-lane")
    (drive,) = life.drives
    assert drive.nodes == ("b3",)
    assert "m4-lane" in life.row.way.held
    life.row.on_reached(drive.order, 0, 1.0)
    assert set(life.row.way.held) == {"b3"}


def test_a_way_that_the_body_refuses_keeps_all_that_was_held() -> None:
    life = NewLife("b3", "m4-lane", drives_beyond=True)
    life.regrant("b3", "m4-lane", "c3")
    # It was past m4-lane when it was told to end there, and ends its way at c3 instead.
    life.row.relocate("m4-lane", "c3", 0.5, past_m=0.2, speed_mps=1.0)
    assert {"b3", "m4-lane", "c3"} <= set(life.row.way.held)
    life.row.on_reached(life.drives[-1].order, 0, 1.0)
    life.row.sense(0.0, 0.0)
    assert set(life.row.way.held) == {"c3"}


@pytest.mark.parametrize("epoch", [4, 3 * 2**20 + 1])
def test_a_recovery_poll_is_answered_under_its_epoch_when_it_is_known_where_the_body_goes(epoch: int) -> None:
    life = NewLife("b3", "m4-lane", drives_beyond=True)
    district = TRAFFIC.places.district_of["c3"]
    replica = TRAFFIC.places.replicas_of[district][1]
    asked = HoldsAsked(district=district, epoch=epoch, recovery_poll=True)
    before = len(life.out)
    life.row.on_holds_asked(replica, asked, 0.2)
    assert life.out[before:] == []
    life.row.on_reached(life.drives[0].order, 0, 1.0)
    life.row.on_holds_asked(replica, asked, 1.2)
    assert life.request(district).epoch == epoch


@pytest.mark.parametrize("held", [False, True])
def test_a_vehicle_tells_up_to_where_it_may_drive(held: bool) -> None:
    async def main() -> None:
        body = Floor(PLANT, clock(), seed=1).vehicles["ATV1"]
        spec = PLANT.fleet["ATV1"]
        way = PLANT.routes(spec.type).way(spec.node, PLANT.node_of("M1")).nodes
        assert body.sense().base_end == ""
        if held:
            body.instruct(Hold())
        body.instruct(Drive(order=1, nodes=way, released=3))
        assert (body.sense().node, body.sense().base_end) == (spec.node, way[2])
        body.instruct(Drive(order=2, nodes=(body.sense().next_node,), released=1))
        assert body.sense().base_end == ""

    run(main(), JUMP)
