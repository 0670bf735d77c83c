"""What the driver orders, and how it follows it (behaviours 6 to 16, 18, 23 and 25 of docs/vehicles.md)."""

from __future__ import annotations

import json
from itertools import pairwise
from typing import Any

import msgspec
import pytest
from vda_rig import FLOWING, PROFILE, Rig
from yard import PICK, TO_CORNER, drive

from dray.adapters.vda5050.profile import ActionUse
from dray.body import (
    ActionDone,
    ActionFailed,
    Charge,
    Drive,
    Drop,
    LimitSpeed,
    OpenDock,
    ReleaseWay,
    WayDone,
)
from dray_sim.vda5050.misbehaviour import Misbehaviour

AROUND = ("west", "middle", "east")
ALL_PASSED = [(node, index) for index, node in enumerate(TO_CORNER)]


def bring_to_machine(rig: Rig) -> None:
    """What is on board, from west to M1."""
    rig.do(drive(*TO_CORNER[:-1], order=6), for_s=120.0)
    rig.yard.workcell.instruct(OpenDock(vehicle="ATV1", item="shaft", quantity=20))
    rig.do(Drop(order=7, station="M1"), for_s=60.0)


def nodes_of(order: dict[str, Any]) -> list[str]:
    return [node["nodeId"] for node in order["nodes"]]


def test_06_picking_dropping_and_charging_are_orders_of_their_own() -> None:
    rig = Rig(FLOWING)
    rig.run(1.0)
    rig.do(PICK, for_s=60.0)
    bring_to_machine(rig)
    rig.do(Drive(order=8, nodes=("north", "corner"), released=2), for_s=60.0)
    rig.do(Charge(order=9, charger="CH2"), for_s=10.0)
    assert [type(report) for report in rig.heard if isinstance(report, ActionDone | ActionFailed)] == [
        ActionDone
    ] * 2
    with_actions = [order for order in rig.orders() if any(node["actions"] for node in order["nodes"])]
    assert [nodes_of(order) for order in with_actions] == [["west"], ["north"], ["corner"]]
    assert [order["orderUpdateId"] for order in with_actions] == [0, 0, 0]
    assert rig.body.sense().charging


def test_07_an_action_that_only_waits_is_tried_again_with_its_node_listed_twice() -> None:
    rig = Rig(quirks=Misbehaviour(no_action_at_last_node=True))
    rig.run(1.0)
    assert rig.do(PICK, for_s=90.0) == [ActionDone(order=5)]
    first, second = rig.orders()
    assert (nodes_of(first), nodes_of(second)) == (["west"], ["west", "west"])
    assert [node["sequenceId"] for node in second["nodes"]] == [0, 2]
    assert len(rig.vehicle.done) == 1


def test_07_an_action_that_waits_even_so_fails() -> None:
    rig = Rig(quirks=Misbehaviour(no_action_at_last_node=True))
    rig.run(1.0)
    rig.vehicle._begin = lambda action: None  # type: ignore[method-assign]
    assert rig.do(PICK, for_s=120.0) == [ActionFailed(order=5, reason="the action only waits")]


def test_08_each_step_is_an_order_of_its_own_without_a_horizon() -> None:
    rig = Rig()
    rig.do(drive(*TO_CORNER), for_s=150.0)
    assert [nodes_of(order) for order in rig.orders()] == [list(pair) for pair in pairwise(TO_CORNER)]
    assert all(node["released"] for order in rig.orders() for node in order["nodes"])
    assert rig.passed() == ALL_PASSED


def test_08_a_base_is_no_longer_than_its_profile_says_and_never_beyond_what_is_released() -> None:
    rig = Rig(FLOWING)
    rig.do(Drive(order=1, nodes=TO_CORNER, released=3), for_s=100.0)
    assert rig.passed() == ALL_PASSED[:3]
    told = {node["nodeId"] for order in rig.orders() for node in order["nodes"]}
    assert told == {"west", "middle", "east"}
    rig.do(ReleaseWay(order=1, released=5), for_s=100.0)
    assert rig.heard[-1] == WayDone(order=1, node="corner")


def test_08_a_horizon_is_told_where_the_profile_allows_it_and_is_not_driven() -> None:
    rig = Rig(msgspec.structs.replace(FLOWING, horizon=2))
    rig.do(Drive(order=1, nodes=TO_CORNER, released=2), for_s=100.0)
    (order,) = rig.orders()
    assert [(node["nodeId"], node["released"]) for node in order["nodes"]] == [
        ("west", True),
        ("middle", True),
        ("east", False),
        ("north", False),
    ]
    assert rig.passed() == ALL_PASSED[:2]


def test_08_a_way_is_replaced_at_the_end_of_the_lane_and_a_horizon_taken_back() -> None:
    rig = Rig(msgspec.structs.replace(FLOWING, horizon=2, base_m=0.0))
    rig.do(Drive(order=1, nodes=TO_CORNER, released=2), for_s=5.0)
    assert rig.body.sense().next_node == "middle"
    rig.do(Drive(order=2, nodes=("middle", "pit"), released=2), for_s=60.0)
    assert rig.passed() == [("west", 0), ("middle", 0), ("pit", 1)]
    assert rig.heard[-1] == WayDone(order=2, node="pit")
    assert rig.do(Drive(order=3, nodes=("pit", "middle"), released=2), for_s=60.0)[-1] == WayDone(
        order=3, node="middle"
    )


def test_09_more_of_the_way_is_an_update_that_begins_with_the_last_released_node() -> None:
    rig = Rig(FLOWING)
    rig.do(drive(*TO_CORNER), for_s=150.0)
    orders = rig.orders()
    assert len({order["orderId"] for order in orders}) == 1
    assert [order["orderUpdateId"] for order in orders] == list(range(len(orders)))
    assert len(orders) > 1
    for before, after in pairwise(orders):
        assert after["nodes"][0] == before["nodes"][-1]
        assert after["edges"][0]["sequenceId"] == before["nodes"][-1]["sequenceId"] + 1
    assert rig.passed() == ALL_PASSED
    slow = Rig()
    slow.do(drive(*TO_CORNER), for_s=150.0)
    assert _arrived_s(rig) < _arrived_s(slow)


def _arrived_s(rig: Rig) -> float:
    states = [(when, said) for when, who, topic, said in rig.wire if (who, topic) == ("it", "state")]
    return next(when for when, said in states if said["lastNodeId"] == "corner")


def test_10_an_order_is_said_again_unchanged_until_the_vehicle_shows_it() -> None:
    rig = Rig(quirks=Misbehaviour(ignores_first_orders=2))
    rig.do(drive("west", "middle"), for_s=40.0)
    bodies = [
        {key: value for key, value in said.items() if key not in ("headerId", "timestamp")}
        for said in rig.said("order")
    ]
    assert len(bodies) == 3
    assert bodies[0] == bodies[1] == bodies[2]
    assert [said["headerId"] for said in rig.said("order")] == [0, 1, 2]
    assert rig.heard[-1] == WayDone(order=1, node="middle")


def test_10_a_refusal_in_silence_is_found_by_time_and_tried_under_another_id() -> None:
    rig = Rig(quirks=Misbehaviour(refuses_every_second=True))
    for second in range(120):
        rig.clock.call_at(float(second), rig.vehicle.say_state)
    rig.do(drive(*AROUND), for_s=100.0)
    assert rig.heard[-1] == WayDone(order=1, node="east")
    assert len({order["orderId"] for order in rig.orders()}) == 4
    assert rig.failures() == []


def test_10_a_vehicle_that_takes_nothing_fails_the_way() -> None:
    rig = Rig(quirks=Misbehaviour(ignores_first_orders=1000))
    for second in range(200):
        rig.clock.call_at(float(second), rig.vehicle.say_state)
    rig.do(drive(*AROUND), for_s=120.0)
    assert rig.failures() == ["the vehicle does not take the order, and does not say why"]
    assert rig.body.sense().next_node == "west"


def test_11_a_refusal_is_told_from_warnings_that_linger() -> None:
    rig = Rig(quirks=Misbehaviour(lingering_warnings=True))
    rig.vehicle.condition.errors += [
        ("orderError", "WARNING", "of old", {"orderId": "ATV1-0-7"}),
        ("orderError", "WARNING", "of nothing", {}),
    ]
    rig.do(drive(*AROUND), for_s=60.0)
    assert rig.heard[-1] == WayDone(order=1, node="east")
    assert len(rig.orders()) == 2


def test_12_an_order_is_said_when_the_vehicle_is_idle_and_a_race_is_tried_again() -> None:
    rig = Rig(quirks=Misbehaviour(busy_after_s=1.5))
    rig.do(drive(*TO_CORNER), for_s=150.0)
    assert rig.passed() == ALL_PASSED
    assert rig.heard[-1] == WayDone(order=1, node="corner")
    assert 4 + 3 <= len(rig.orders()) <= 4 + 6
    assert rig.failures() == []


def test_12_nothing_is_said_while_another_order_is_active() -> None:
    rig = Rig()
    rig.run(1.0)
    rig.vehicle.on_message("order", json.dumps(_foreign()).encode())
    rig.run(3.0)
    rig.do(Drive(order=1, nodes=(rig.body.sense().next_node, "east"), released=2), for_s=4.0)
    assert rig.orders() == []
    rig.run(40.0)
    assert rig.heard[-1] == WayDone(order=1, node="east")


def _foreign() -> dict[str, Any]:
    nodes = [
        {"nodeId": node, "sequenceId": 2 * index, "released": True, "actions": []}
        for index, node in enumerate(("west", "middle"))
    ]
    edge = {
        "edgeId": "e",
        "sequenceId": 1,
        "released": True,
        "startNodeId": "west",
        "endNodeId": "middle",
        "actions": [],
    }
    return {"orderId": "somebody", "orderUpdateId": 0, "nodes": nodes, "edges": [edge]}


def test_13_arrival_is_judged_by_the_last_node_too() -> None:
    rig = Rig(quirks=Misbehaviour(keeps_node_states=True))
    rig.do(drive(*AROUND), for_s=80.0)
    assert rig.passed() == [("west", 0), ("middle", 1), ("east", 2)]
    assert rig.heard[-1] == WayDone(order=1, node="east")


def test_13_an_order_that_is_forgotten_at_its_end_was_done() -> None:
    rig = Rig(quirks=Misbehaviour(forgets_finished_order=True))
    rig.do(drive(*AROUND), for_s=80.0)
    assert rig.heard[-1] == WayDone(order=1, node="east")
    assert rig.failures() == []


def test_14_skipped_nodes_are_reported_once_each_in_order() -> None:
    rig = Rig(msgspec.structs.replace(FLOWING, base_m=100.0), Misbehaviour(tells_ends_only=True))
    rig.do(drive(*TO_CORNER), for_s=150.0)
    assert rig.passed() == ALL_PASSED
    assert rig.heard[-1] == WayDone(order=1, node="corner")
    (order,) = rig.orders()
    assert nodes_of(order) == list(TO_CORNER)


def test_15_cancel_is_waited_for_until_it_is_finished_and_no_update_follows_it() -> None:
    rig = Rig(FLOWING, Misbehaviour(cancel_s=6.0))
    rig.run(1.0)
    rig.do(PICK, for_s=3.0)
    rig.do(drive("west", "middle", order=6), for_s=5.0)
    assert len(rig.orders()) == 1
    rig.run(40.0)
    assert [type(report) for report in rig.heard if not hasattr(report, "index")] == [ActionFailed, WayDone]
    assert len({action["actionId"] for action in rig.instant("cancelOrder")}) == 1


def test_15_a_cancel_that_is_lost_is_said_again_but_not_for_ever() -> None:
    rig = Rig()
    rig.run(1.0)
    rig.do(PICK, for_s=3.0)
    rig.vehicle._ignored["instantActions"] = 2
    rig.do(drive("west", "middle", order=6), for_s=30.0)
    assert len(rig.instant("cancelOrder")) == 3
    assert rig.heard[-1] == WayDone(order=6, node="middle")
    deaf = Rig()
    deaf.run(1.0)
    deaf.do(PICK, for_s=3.0)
    deaf.vehicle._ignored["instantActions"] = 1000
    deaf.vehicle._body.break_down("")
    deaf.do(drive("west", "middle", order=6), for_s=100.0)
    assert len(deaf.instant("cancelOrder")) == 5


def test_15_nothing_is_cancelled_that_is_not_there() -> None:
    rig = Rig(quirks=Misbehaviour(idle_cancel_kills_next=True))
    rig.do(drive(*AROUND), for_s=60.0)
    rig.do(Drive(order=2, nodes=("east", "north"), released=2), for_s=60.0)
    rig.do(Drive(order=3, nodes=("north",), released=1), for_s=10.0)
    assert rig.instant("cancelOrder") == []
    assert rig.heard[-1] == WayDone(order=3, node="north")


@pytest.mark.parametrize("how", ["last_node", "temporary_node"])
def test_16_after_a_stop_between_two_nodes_it_goes_on_from_where_it_is(how: Any) -> None:
    rig = Rig(msgspec.structs.replace(PROFILE, restart_at=how))
    rig.do(drive(*AROUND), for_s=6.0)
    rig.vehicle.restart()
    rig.run(3.0)
    assert len(rig.failures()) == 1
    state = rig.body.sense()
    assert (state.node, state.next_node) == ("west", "middle")
    assert 1.0 < state.pose.x_m < 9.0
    rig.do(Drive(order=2, nodes=("middle", "east"), released=2), for_s=60.0)
    assert rig.heard[-1] == WayDone(order=2, node="east")
    again = rig.orders()[1]
    first = again["nodes"][0]
    assert first["nodeId"] == ("west" if how == "last_node" else "here")
    assert first["nodePosition"]["x"] == pytest.approx(state.pose.x_m)
    assert rig.passed()[1:] == [("middle", 0), ("east", 1)]


def test_18_an_action_is_found_by_its_id_and_finished_beats_waiting() -> None:
    rig = Rig(quirks=Misbehaviour(actions_twice=True))
    rig.run(1.0)
    assert rig.do(PICK, for_s=60.0) == [ActionDone(order=5)]


@pytest.mark.parametrize("version", ["2.0", "2.1", "3.0"])
@pytest.mark.parametrize("profile", [PROFILE, FLOWING, msgspec.structs.replace(FLOWING, horizon=2)])
def test_23_it_speaks_all_versions(version: Any, profile: Any) -> None:
    rig = Rig(msgspec.structs.replace(profile, version=version))
    rig.run(1.0)
    rig.do(PICK, for_s=60.0)
    bring_to_machine(rig)
    assert rig.heard[-1] == ActionDone(order=7)
    assert len(rig.vehicle.done) == 2
    names = {name for said in rig.said("order") for edge in said["edges"] for name in edge}
    assert ("maximumSpeed" in names, "startNodeId" in names) == (version == "3.0", version != "3.0")


def test_23_the_list_of_instant_actions_has_the_name_that_the_profile_says() -> None:
    rig = Rig(msgspec.structs.replace(PROFILE, instant_actions="instantActions"))
    rig.run(1.0)
    said = rig.said("instantActions")[0]
    assert said["instantActions"] == said["actions"]


def test_25_charging_is_stopped_before_it_drives_and_names_come_from_the_profile() -> None:
    rig = Rig(battery_frac=0.5, node="east")
    rig.run(1.0)
    rig.do(Charge(order=1, charger="CH1"), for_s=20.0)
    assert rig.body.sense().charging
    assert rig.heard == []
    rig.do(Drive(order=2, nodes=("east", "north"), released=2), for_s=60.0)
    stop = next(i for i, message in enumerate(rig.wire) if "stopCharging" in json.dumps(message[3]))
    step = next(i for i, message in enumerate(rig.wire) if '"north"' in json.dumps(message[3]))
    assert stop < step
    assert rig.heard[-1] == WayDone(order=2, node="north")
    assert rig.failures() == []


def test_25_a_charge_ends_when_the_battery_is_full() -> None:
    rig = Rig(battery_frac=0.985, node="east")
    rig.run(1.0)
    assert rig.do(Charge(order=1, charger="CH1"), for_s=300.0) == [ActionDone(order=1)]


def test_25_parameters_are_filled_in() -> None:
    use = ActionUse("load", parameters={"text": "{item} x {quantity}", "n": "{quantity}", "fixed": 3.5})
    assert use.values(item="shaft", quantity=20) == {"text": "shaft x 20", "n": 20, "fixed": 3.5}


def test_lanes_are_limited_by_the_plant_by_people_and_by_the_speed_that_was_set() -> None:
    rig = Rig(msgspec.structs.replace(FLOWING, base_m=100.0))
    rig.do(LimitSpeed(speed_frac=0.6), for_s=1.0)
    rig.do(Drive(order=1, nodes=("west", "middle", "pit"), released=3, limits_mps=(0.3, None)), for_s=1.0)
    (order,) = rig.orders()
    assert [edge["maxSpeed"] for edge in order["edges"]] == [0.3, 0.5]


def test_an_update_that_is_shown_and_not_driven_costs_a_new_order_and_no_more() -> None:
    rig = Rig(FLOWING, Misbehaviour(loses_updates=True))
    rig.do(drive(*TO_CORNER), for_s=200.0)
    assert rig.passed() == ALL_PASSED
    assert rig.heard[-1] == WayDone(order=1, node="corner")
