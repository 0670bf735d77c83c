"""What a vehicle complains of: an order that was just said, its own body, or something that ends with the next order."""

from __future__ import annotations

from typing import Any

import msgspec
import pytest
from vda_rig import FLOWING, PROFILE, Rig
from yard import PICK, TO_CORNER, drive

from dray.adapters.vda5050.profile import load_profile, parse_profile
from dray.body import ActionFailed, Drive, ProblemCleared, WayBlocked, WayDone, WayFree
from dray.errors import SettingsError
from dray_sim.vda5050.misbehaviour import Misbehaviour

V3 = msgspec.structs.replace(PROFILE, version="3.0")
KEPT = msgspec.structs.replace(PROFILE, kept_until_order=("pathBlocked",))


def stop_with(rig: Rig, kind: str, level: str, *, gives_up: bool = True, node: str = "middle") -> None:
    """The vehicle stops on its lane, and complains until it takes another order."""
    vehicle = rig.vehicle
    if gives_up:
        vehicle.order.give_up()  # type: ignore[union-attr]
        vehicle._body.power_off()
        vehicle._body.power_on()
        vehicle._way = []
    else:
        vehicle._body.instruct(Drive(order=0, nodes=(rig.sim.sense().next_node,), released=1))
    vehicle.condition.errors.append((kind, level, "cannot reach the node", {"nodeId": node}))
    accept = vehicle._accept

    def and_forget(order: Any) -> None:
        vehicle.condition.errors = [error for error in vehicle.condition.errors if error[0] != kind]
        accept(order)

    vehicle._accept = and_forget  # type: ignore[method-assign]
    vehicle.say_state()


UNREACHABLE = [
    (V3, "NODE_UNREACHABLE", "CRITICAL"),
    (PROFILE, "noPath", "CRITICAL"),
    (KEPT, "pathBlocked", "FATAL"),
]


def reaching_nothing(profile: Any, kind: str, level: str) -> Rig:
    """A vehicle that has stopped on its first lane for that, 30 s ago."""
    rig = Rig(profile)
    rig.do(drive("west", "middle", "east"), for_s=6.0)
    stop_with(rig, kind, level)
    rig.run(30.0)
    return rig


@pytest.mark.parametrize(("profile", "kind", "level"), UNREACHABLE)
def test_an_error_that_lasts_until_the_next_order_keeps_it_from_none(
    profile: Any, kind: str, level: str
) -> None:
    rig = reaching_nothing(profile, kind, level)
    assert rig.problems() == [f"{kind}: cannot reach the node"]
    assert rig.failures() == [f"{kind}: cannot reach the node"]
    assert rig.heard[-1] == ProblemCleared()
    node = rig.body.sense().next_node
    rig.do(Drive(order=2, nodes=(node, "east"), released=2), for_s=60.0)
    assert rig.heard[-1] == WayDone(order=2, node="east")
    assert len(rig.problems()) == 1


@pytest.mark.parametrize(("profile", "kind", "level"), UNREACHABLE)
def test_a_node_that_it_cannot_reach_is_said_as_a_blocked_lane_before_its_way_is_lost(
    profile: Any, kind: str, level: str
) -> None:
    rig = reaching_nothing(profile, kind, level)
    blocked = WayBlocked(order=1, start="west", end="middle", entered=True)
    assert rig.of(WayBlocked) == [blocked]
    failed = rig.of(ActionFailed)[0]
    assert rig.heard.index(blocked) < rig.heard.index(failed), "its next way is planned with that"
    assert rig.of(WayFree) == [], "an order that is taken does not tell that the lane is free"


def test_the_node_that_an_error_names_is_the_one_whose_lane_is_blocked() -> None:
    rig = Rig(msgspec.structs.replace(FLOWING, version="3.0"))
    rig.do(drive(*TO_CORNER), for_s=6.0)
    order = rig.orders()[-1]
    named, before = order["nodes"][2]["nodeId"], order["nodes"][1]["nodeId"]
    stop_with(rig, "NODE_UNREACHABLE", "CRITICAL", node=named)
    rig.run(30.0)
    assert rig.of(WayBlocked) == [WayBlocked(order=1, start=before, end=named, entered=False)]


def test_a_vehicle_that_stands_at_a_node_has_not_entered_the_lane_that_it_cannot_drive() -> None:
    rig = Rig(V3)
    rig.run(1.0)
    rig.vehicle._proceed = lambda: None  # type: ignore[method-assign]
    rig.do(drive("west", "middle"), for_s=3.0)
    stop_with(rig, "NODE_UNREACHABLE", "CRITICAL", gives_up=False)
    rig.run(20.0)
    assert rig.of(WayBlocked) == [WayBlocked(order=1, start="west", end="middle", entered=False)]


def test_a_critical_error_about_something_else_blocks_no_lane() -> None:
    rig = Rig(V3)
    rig.do(drive("west", "middle", "east"), for_s=6.0)
    stop_with(rig, "RELEASE_LOST", "CRITICAL")
    rig.run(30.0)
    assert rig.failures() == ["RELEASE_LOST: cannot reach the node"]
    assert rig.of(WayBlocked) == []


def test_a_critical_error_cancels_an_order_that_the_vehicle_keeps() -> None:
    rig = Rig(V3)
    rig.do(drive("west", "middle", "east"), for_s=6.0)
    rig.vehicle._body.power_off()
    rig.vehicle._body.power_on()
    rig.vehicle.condition.errors.append(("NODE_UNREACHABLE", "CRITICAL", "", {}))
    rig.vehicle.say_state()
    rig.run(30.0)
    assert rig.failures() == ["NODE_UNREACHABLE"]
    assert len({action["actionId"] for action in rig.instant("cancelOrder")}) == 1


def test_a_critical_error_that_no_order_ends_is_told_for_longer_each_time_and_asks_little() -> None:
    rig = Rig(V3)
    rig.run(1.0)
    rig.vehicle.condition.errors.append(("RELEASE_LOST", "CRITICAL", "", {}))
    rig.vehicle._proceed = lambda: None  # type: ignore[method-assign]
    rig.vehicle.say_state()
    for number in range(60):
        rig.do(Drive(order=10 + number, nodes=("west", "middle"), released=2), for_s=20.0)
    assert 3 <= len(rig.problems()) <= 12
    assert len(rig.orders()) <= 15


def test_a_fatal_error_of_the_vehicle_stays_a_problem() -> None:
    rig = Rig(V3)
    rig.run(1.0)
    rig.vehicle.condition.errors.append(("LOCALIZATION_ERROR", "FATAL", "", {}))
    rig.vehicle.say_state()
    rig.run(1.0)
    rig.do(drive("west", "middle"), for_s=300.0)
    assert rig.orders() == []
    assert rig.body.sense().problem == "LOCALIZATION_ERROR"


def refuse_with(rig: Rig, kind: str, level: str, references: dict[str, str], while_said: str = "") -> None:
    """Every order is refused like this; with `while_said` only those that say that word."""
    vehicle, hear = rig.vehicle, rig.vehicle.on_message
    complaint = (kind, level, "not supported", references)

    def on_message(topic: str, data: bytes) -> None:
        if topic != "order" or while_said.encode() not in data:
            if topic == "order":
                vehicle.condition.errors = []
            hear(topic, data)
        else:
            vehicle.condition.errors = [complaint]
            vehicle.say_state()

    vehicle.on_message = on_message  # type: ignore[method-assign]


REFUSALS = [
    (V3, "UNSUPPORTED_PARAMETER", "CRITICAL", {"parameter": "maximumSpeed"}),
    (V3, "UNSUPPORTED_PARAMETER", "CRITICAL", {"maximumSpeed": "1.5"}),
    (V3, "VALIDATION_FAILURE", "WARNING", {}),
    (V3, "UNKNOWN_MAP_ID", "WARNING", {}),
    (PROFILE, "validationError", "FATAL", {"topic": "order"}),
    (PROFILE, "orderError", "FATAL", {}),
]


@pytest.mark.parametrize(("profile", "kind", "level", "references"), REFUSALS)
def test_a_refusal_that_does_not_name_the_order_is_told_with_its_words_and_ends_with_its_cause(
    profile: Any, kind: str, level: str, references: dict[str, str]
) -> None:
    rig = Rig(profile)
    rig.run(1.0)
    refuse_with(rig, kind, level, references)
    rig.do(drive("west", "middle"), for_s=120.0)
    assert rig.failures() == [f"{kind}: not supported"]
    # It keeps its error, so that the next tries are refused in silence: that takes longer than it may.
    ids = {order["orderId"] for order in rig.orders()}
    assert 1 < len(ids) < profile.tries
    assert rig.problems() == []
    del rig.vehicle.on_message
    rig.do(drive("west", "middle", order=2), for_s=60.0)
    assert rig.heard[-1] == WayDone(order=2, node="middle")


def test_a_vehicle_that_refuses_order_after_order_is_a_problem_for_longer_each_time_until_it_takes_one() -> (
    None
):
    rig = Rig(msgspec.structs.replace(PROFILE, tries=1))
    rig.run(1.0)
    refuse_with(rig, "orderError", "FATAL", {})
    told = "it has refused {} orders one after the other: orderError: not supported"

    def refused(number: int) -> float:
        """Seconds for which it is a problem then, asked every ten."""
        rig.do(drive("west", "middle", order=number), for_s=0.0)
        spans = 0
        for _ in range(30):
            rig.run(10.0)
            spans += rig.body.sense().problem == told.format(number)
        assert len(rig.failures()) == number
        return 10.0 * spans

    assert [refused(number) for number in (1, 2, 3)] == [0.0, 60.0, 120.0]
    assert rig.problems() == [told.format(2), told.format(3)]
    del rig.vehicle.on_message
    rig.do(drive("west", "middle", order=4), for_s=60.0)
    assert rig.heard[-1] == WayDone(order=4, node="middle")


def test_a_refusal_of_an_order_that_it_shows_all_the_same_ends_it() -> None:
    rig = Rig()
    rig.run(1.0)
    rig.vehicle._proceed = lambda: None  # type: ignore[method-assign]
    rig.body.instruct(drive("west", "middle"))
    rig.run(2.0)
    named = {"orderId": rig.orders()[0]["orderId"]}
    rig.vehicle.condition.errors.append(("noRouteError", "FATAL", "no route", named))
    rig.vehicle.say_state()
    rig.run(20.0)
    assert rig.failures() == ["noRouteError: no route"]
    assert rig.problems() == []


@pytest.mark.parametrize("action", [False, True])
def test_what_is_not_supported_is_left_out_where_the_profile_allows_it(action: bool) -> None:
    word = "weight" if action else "maximumSpeed"
    heavy = msgspec.structs.replace(PROFILE.pick, parameters={**PROFILE.pick.parameters, "weight": 3.5})
    rig = Rig(msgspec.structs.replace(V3, pick=heavy, leave_out=(word,)))
    rig.run(1.0)
    refuse_with(rig, "UNSUPPORTED_PARAMETER", "CRITICAL", {"parameter": word}, while_said=f'"{word}"')
    rig.do(PICK if action else drive("west", "middle", "east"), for_s=90.0)
    assert rig.failures() == []
    assert [word in str(order) for order in rig.orders()] == [True] + [False] * (len(rig.orders()) - 1)
    assert rig.notes[-1] == "left out of orders, since the vehicle says: UNSUPPORTED_PARAMETER: not supported"


def test_a_speed_limit_is_never_left_out_unless_the_profile_says_so() -> None:
    rig = Rig(V3)
    rig.run(1.0)
    refuse_with(
        rig, "UNSUPPORTED_PARAMETER", "CRITICAL", {"parameter": "maximumSpeed"}, while_said="maximumSpeed"
    )
    assert isinstance(rig.do(drive("west", "middle"), for_s=90.0)[-1], ActionFailed)
    assert all("maximumSpeed" in str(order) for order in rig.orders())


def test_what_every_order_needs_cannot_be_left_out() -> None:
    with pytest.raises(SettingsError, match="leave_out: no order is one without nodeId"):
        parse_profile(b"leave_out: [nodeId]", "mine.yaml")
    assert "trajectory" in load_profile("default").leave_out


def test_a_warning_about_an_order_that_was_said_twice_refuses_no_update_of_it() -> None:
    """SAME_ORDER_UPDATE_ID names the order and lasts: states still have it when the next update is on its way."""
    rig = Rig(
        msgspec.structs.replace(FLOWING, version="3.0"), Misbehaviour(lingering_warnings=True), delay_s=0.4
    )
    for tick in range(750):
        rig.clock.call_at(tick / 5.0, rig.vehicle.say_state)
    rig.do(drive(*TO_CORNER), for_s=3.0)
    twice = {"orderId": rig.orders()[0]["orderId"], "orderUpdateId": "0"}
    rig.vehicle.condition.errors.append(("SAME_ORDER_UPDATE_ID", "WARNING", "said twice", twice))
    rig.run(150.0)
    assert [order["orderUpdateId"] for order in rig.orders()] == [0, 1, 2]
    assert rig.failures() == []
    assert rig.heard[-1] == WayDone(order=1, node="corner")
