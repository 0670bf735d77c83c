"""A load that a person hands over at a node where no station is: the vehicle waits for that person, and not for ever."""

from __future__ import annotations

from collections import Counter

import msgspec
import pytest
from official_schemas import MISSING, folder, objections
from vda_rig import FLOWING, PROFILE, Rig
from yard import drive

from dray.adapters.vda5050.profile import ActionUse, Profile, parse_profile, write_profile
from dray.body import ActionDone, ActionFailed, Pick
from dray.errors import SettingsError
from dray_sim.bodies.held_out import HeldOut

BY_HAND = ActionUse(
    "waitForTrigger",
    parameters={
        "triggerType": "manualLoading",
        "stationName": "{node}",
        "loadType": "{item}",
        "quantity": "{quantity}",
    },
)

WAITING_S = 30.0

PATIENT = msgspec.structs.replace(PROFILE, pick_by_hand=BY_HAND, by_hand_s=WAITING_S)

FETCH = Pick(order=5, station="pit", item="shaft", quantity=20)


class Person:
    """Somebody with shafts in the hands, who comes to the pit."""

    def __init__(self, rig: Rig) -> None:
        self._held = HeldOut(Counter(shaft=20))
        rig.yard.stands.add("pit", self._held, "pit")

    def comes(self) -> None:
        self._held.offer("shaft", 20)


def at_the_pit(rig: Rig) -> Person:
    """The vehicle has driven to where the goods are handed over."""
    person = Person(rig)
    rig.do(drive("west", "middle", "pit"), for_s=90.0)
    assert rig.passed()[-1][0] == "pit"
    return person


def actions_of(rig: Rig, kind: str) -> list[str]:
    """The ids of all actions of this kind that were ordered."""
    nodes = [node for order in rig.orders() for node in order["nodes"]]
    return [
        action["actionId"] for node in nodes for action in node["actions"] if action["actionType"] == kind
    ]


@pytest.mark.parametrize("profile", [PATIENT, msgspec.structs.replace(FLOWING, pick_by_hand=BY_HAND)])
def test_it_drives_to_the_person_and_is_loaded_there(profile: Profile) -> None:
    rig = Rig(profile)
    at_the_pit(rig).comes()
    assert rig.do(FETCH, for_s=30.0) == [ActionDone(order=5)]
    state = rig.body.sense()
    assert (state.load, state.node) == ("shaft", "pit")
    assert (len(actions_of(rig, "waitForTrigger")), actions_of(rig, "pick")) == (1, [])


def test_it_waits_for_a_person_who_comes_later() -> None:
    rig = Rig(PATIENT)
    person = at_the_pit(rig)
    # Longer than an action that needs nobody may wait.
    assert rig.do(FETCH, for_s=PROFILE.waiting_s + 5.0) == []
    person.comes()
    rig.run(30.0)
    assert rig.of(ActionDone) == [ActionDone(order=5)]
    assert len(actions_of(rig, "waitForTrigger")) == 1


def test_a_vehicle_that_shows_its_waiting_as_waiting_is_waited_for_too() -> None:
    rig = Rig(PATIENT)
    at_the_pit(rig)
    rig.vehicle._begin = lambda action: None  # type: ignore[method-assign]
    rig.do(FETCH, for_s=PROFILE.waiting_s + 5.0)
    assert rig.failures() == []


def test_where_nobody_comes_its_order_is_cancelled_and_it_can_drive_on_or_ask_again() -> None:
    rig = Rig(PATIENT)
    person = at_the_pit(rig)
    reports = rig.do(FETCH, for_s=WAITING_S + 10.0)
    assert reports == [ActionFailed(order=5, reason="nobody has loaded it by hand")]
    assert len(rig.instant("cancelOrder")) >= 1
    person.comes()
    again = msgspec.structs.replace(FETCH, order=6)
    assert rig.do(again, for_s=30.0) == [ActionDone(order=6)]
    rig.do(drive("pit", "middle", order=7), for_s=60.0)
    assert rig.passed()[-1][0] == "middle"


def test_a_new_life_waits_on_and_never_asks_twice() -> None:
    rig = Rig(PATIENT)
    person = at_the_pit(rig)
    rig.do(FETCH, for_s=10.0)
    rig.begin_life()
    rig.do(msgspec.structs.replace(FETCH, order=2), for_s=5.0)
    person.comes()
    rig.run(30.0)
    assert rig.of(ActionDone) == [ActionDone(order=2)]
    assert len(set(actions_of(rig, "waitForTrigger"))) == 1
    assert len(rig.vehicle.done) == 1


def test_a_way_that_is_given_while_it_waits_ends_the_wait() -> None:
    rig = Rig(PATIENT)
    at_the_pit(rig)
    rig.do(FETCH, for_s=10.0)
    rig.do(drive("pit", "middle", order=6), for_s=60.0)
    assert [failed.order for failed in rig.of(ActionFailed)] == [5]
    assert rig.passed()[-1][0] == "middle"


def test_a_profile_may_have_it_done_as_any_other_pick() -> None:
    rig = Rig(msgspec.structs.replace(PROFILE, pick_by_hand=PROFILE.pick))
    at_the_pit(rig).comes()
    assert rig.do(FETCH, for_s=30.0) == [ActionDone(order=5)]
    assert len(actions_of(rig, "pick")) == 1


LISTED = (
    b"version: '3.0'\npick_by_hand: {type: waitForTrigger, parameters: {triggerType: [LOCAL, 'at {node}']}}\n"
)


def picking_by(profile: Profile) -> Rig:
    rig = Rig(msgspec.structs.replace(PATIENT, version="3.0", pick_by_hand=profile.pick_by_hand))
    at_the_pit(rig)
    rig.do(FETCH, for_s=5.0)
    return rig


def test_a_parameter_may_be_a_list_as_3_0_has_it_for_the_trigger() -> None:
    profile = parse_profile(LISTED, "list.yaml")
    assert parse_profile(write_profile(profile).encode(), "again.yaml") == profile
    nodes = [node for order in picking_by(profile).orders() for node in order["nodes"]]
    (action,) = (action for node in nodes for action in node["actions"])
    assert action["actionParameters"] == [{"key": "triggerType", "value": ["LOCAL", "at pit"]}]


@pytest.mark.skipif(folder() is None, reason=MISSING)
def test_an_order_with_such_a_list_is_one_by_the_official_schema() -> None:
    said = picking_by(parse_profile(LISTED, "list.yaml")).said("order")
    (order,) = (each for each in said if any(node["actions"] for node in each["nodes"]))
    assert objections("3.0", "order", order) == []


def test_a_list_may_hold_texts_only() -> None:
    with pytest.raises(SettingsError, match=r"list\.yaml"):
        parse_profile(b"pick: {type: pick, parameters: {side: [1, {a: 2}]}}", "list.yaml")
    with pytest.raises(SettingsError, match="no parameter can be 'nowhere'"):
        parse_profile(b"pick: {type: pick, parameters: {side: ['{nowhere}']}}", "list.yaml")


def test_a_node_that_the_plant_does_not_have_is_refused() -> None:
    rig = Rig(PATIENT)
    at_the_pit(rig)
    reports = rig.do(Pick(order=8, station="nowhere", item="shaft", quantity=20), for_s=5.0)
    assert reports == [ActionFailed(order=8, reason="no station nowhere")]
