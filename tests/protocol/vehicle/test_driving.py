"""Where a vehicle is on the lanes, and how it gets somewhere else."""

from __future__ import annotations

import pytest
from defaults import PLANT
from effects import instructed
from vehicle_states import standing

from dray.body import ActionFailed, Drive, LimitSpeed, NodePassed, WayDone
from dray.protocol.runtime.life import Life
from dray.protocol.vehicle.drivers.driver import Driver

ROUTES = PLANT.routes("light")


class Seat:
    """A driver, and what it tells the vehicle."""

    def __init__(self, node: str = "p3") -> None:
        self.life = Life()
        self.out = self.life.effects
        self.driver = Driver(PLANT, "light", self.life)
        self.sense(node)

    def sense(self, node: str, speed_mps: float = 0.0) -> None:
        self.driver.sense(standing(PLANT, node, speed_mps=speed_mps))

    @property
    def drives(self) -> list[Drive]:
        return instructed(self.life.effects, Drive)

    def passes(self, index: int, order: int | None = None) -> None:
        way = self.drives[-1]
        number = way.order if order is None else order
        report = NodePassed(order=number, node=way.nodes[index], index=index, battery_frac=0.9)
        self.driver.on_passed(report, 0.0)


def test_a_way_leads_from_here_to_there_and_is_released_as_a_whole() -> None:
    seat = Seat("p3")
    assert seat.driver.go("s3", 100.0)
    [drive] = seat.drives
    assert drive.nodes == ROUTES.way("p3", "s3").nodes
    assert drive.released == len(drive.nodes)
    assert seat.driver.arrives_s == pytest.approx(100.0 + ROUTES.duration_s("p3", "s3"))
    assert seat.driver.ahead == drive.nodes


def test_who_stands_there_already_stays() -> None:
    seat = Seat("p3")
    assert not seat.driver.go("p3", 0.0)
    assert seat.out == []


def test_nodes_that_were_passed_are_ahead_no_longer() -> None:
    seat = Seat("p3")
    seat.driver.go("s3", 0.0)
    seat.passes(0)
    seat.passes(1)
    nodes = seat.drives[-1].nodes
    assert seat.driver.ahead == nodes[2:]
    assert seat.driver.node == nodes[1]
    assert seat.driver.next_node == nodes[2]
    spot = PLANT.nodes[nodes[1]]
    assert seat.driver.position_m == (spot.x_m, spot.y_m)


def test_a_new_way_begins_at_the_end_of_the_lane_it_is_on() -> None:
    seat = Seat("p3")
    seat.driver.go("s3", 0.0)
    seat.passes(0)
    seat.passes(1)
    turn = seat.driver.next_node
    seat.driver.go("p8", 10.0)
    first, second = seat.drives
    assert second.nodes == ROUTES.way(turn, "p8").nodes
    assert second.order > first.order


def test_a_way_back_to_the_node_just_left_is_driven_all_the_same() -> None:
    seat = Seat("p3")
    seat.driver.go("s3", 0.0)
    seat.passes(0)
    assert seat.driver.go("p3", 5.0)
    assert seat.drives[-1].nodes[-1] == "p3"


def test_at_its_end_a_way_is_done() -> None:
    seat = Seat("p3")
    seat.driver.go("s3", 0.0)
    assert seat.driver.on_done(WayDone(order=seat.drives[-1].order, node="s3"), 0.0)
    assert seat.driver.way == seat.driver.ahead == ()
    assert seat.driver.next_node == seat.driver.node == "s3"


def test_the_end_of_a_way_that_was_replaced_is_not_the_end() -> None:
    seat = Seat("p3")
    seat.driver.go("s3", 0.0)
    old = seat.driver.order
    seat.driver.go("p8", 1.0)
    assert not seat.driver.on_done(WayDone(order=old, node="s3"), 0.0)
    assert seat.driver.ahead


def test_a_node_of_a_way_that_was_replaced_does_not_count_on_the_new_one() -> None:
    seat = Seat("p3")
    seat.driver.go("s3", 0.0)
    old = seat.driver.order
    seat.driver.go("p8", 1.0)
    seat.passes(1, order=old)
    assert seat.driver.ahead == seat.drives[-1].nodes


def test_a_refused_way_is_given_up_and_an_older_refusal_is_ignored() -> None:
    seat = Seat("p3")
    seat.driver.go("s3", 0.0)
    old = seat.driver.order
    seat.driver.go("p8", 1.0)
    assert not seat.driver.on_failed(ActionFailed(order=old, reason="replaced"), 0.0)
    assert seat.driver.ahead
    assert seat.driver.on_failed(ActionFailed(order=seat.driver.order, reason="blocked"), 0.0)
    assert seat.driver.ahead == ()


def test_the_failure_of_an_action_is_not_that_of_a_way() -> None:
    seat = Seat("p3")
    order = seat.driver.next_order()
    assert not seat.driver.on_failed(ActionFailed(order=order, reason="no pallet"), 0.0)


def test_every_order_has_a_number_of_its_own() -> None:
    seat = Seat("p3")
    seat.driver.go("s3", 0.0)
    numbers = [seat.driver.order, seat.driver.next_order(), seat.driver.next_order()]
    seat.driver.go("p8", 1.0)
    numbers.append(seat.driver.order)
    assert numbers == sorted(set(numbers))


def test_who_stands_is_at_its_next_node_now_and_who_drives_is_there_later() -> None:
    seat = Seat("p3")
    assert seat.driver.next_node_at_s(50.0) == 50.0
    assert seat.driver.next_node_in_m == 0.0
    seat.driver.go("s3", 50.0)
    seat.passes(0)
    assert seat.driver.next_node_at_s(50.0) > 50.0
    assert seat.driver.next_node_in_m > 0.0


def test_a_way_under_a_speed_limit_takes_as_much_longer() -> None:
    seat = Seat("p3")
    seat.driver.limit_speed(0.5)
    assert [each.speed_frac for each in instructed(seat.out, LimitSpeed)] == [0.5]
    seat.driver.go("s3", 100.0)
    assert seat.driver.arrives_s == pytest.approx(100.0 + 2.0 * ROUTES.duration_s("p3", "s3"))
