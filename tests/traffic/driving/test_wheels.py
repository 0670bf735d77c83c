"""What the body is told of a reserved way."""

from __future__ import annotations

from itertools import count

from dray.body import Drive, ReleaseWay
from dray.plant import load_plant
from dray.plant.restrictions import OPEN
from dray.protocol.traffic.driving.reserved_way import ReservedWay
from dray.protocol.traffic.driving.wheels import Wheels
from dray.protocol.traffic.places import Places

PLACES = Places(load_plant("single-track"))


def at_b3(*ahead: str) -> tuple[ReservedWay, Wheels]:
    """A vehicle that stands at b3, and has been told to drive to the next node of a way."""
    way = ReservedWay(PLACES, "b3")
    way.turn_to(("b3", *ahead))
    way.take_next()
    wheels = Wheels(1.5, 0.6, count(1).__next__, restrictions=lambda: OPEN)
    assert wheels.drive(way, 0.0) == Drive(order=1, nodes=("b3", *ahead), released=2)
    return way, wheels


def test_more_of_the_same_way_is_released() -> None:
    way, wheels = at_b3("m4-lane", "c3")
    way.take_next()
    assert wheels.drive(way, 0.0) == ReleaseWay(order=1, released=3)


def test_a_way_that_passes_a_node_twice_is_not_taken_for_its_end_at_the_first_time() -> None:
    way, wheels = at_b3("m4-lane", "b3", "m4-lane", "c3")
    way.turn_to(("m4-lane", "c3"))
    way.take_next()
    assert wheels.drive(way, 0.0) == Drive(order=2, nodes=("b3", "m4-lane", "c3"), released=3)


def test_the_end_of_such_a_way_is_released_when_it_has_come_there() -> None:
    way, wheels = at_b3("m4-lane", "b3", "m4-lane", "c3")
    for _ in range(2):
        way.take_next()
    for _ in range(2):
        way.pass_next()
    assert way.base == ("m4-lane",)
    assert wheels.drive(way, 0.0) == ReleaseWay(order=1, released=4)
    way.take_next()
    assert wheels.drive(way, 0.0) == ReleaseWay(order=1, released=5)
