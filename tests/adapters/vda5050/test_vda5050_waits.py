"""What the driver waits for has a bound, a reason and a way out: one word of a vehicle alone holds nothing up for ever."""

from __future__ import annotations

from typing import Any

import msgspec
import pytest
from field import reword, say
from vda_rig import FLOWING, PROFILE, Rig
from yard import HOLD, PICK, TO_CORNER, UNHOLD, drive

from dray.body import ActionDone, WayDone

V3 = msgspec.structs.replace(PROFILE, version="3.0")


@pytest.mark.parametrize("status", ["RUNNING", "WAITING", "PAUSED", "INITIALIZING", "BLINKING"])
@pytest.mark.parametrize(
    ("profile", "where"), [(PROFILE, "actionStates"), (V3, "instantActionStates"), (V3, "actionStates")]
)
def test_an_action_of_somebody_else_that_never_ends_holds_no_order_up(
    profile: Any, where: str, status: str
) -> None:
    rig = Rig(profile)
    lamp = {"actionId": "hmi-1", "actionType": "beacon", "actionStatus": status}
    reword(rig, lambda said: said[where].append(lamp))
    say(rig)
    rig.do(drive("west", "middle", "east"), for_s=90.0)
    assert rig.heard[-1] == WayDone(order=1, node="east")
    assert rig.problems() == []


@pytest.mark.parametrize("profile", [PROFILE, FLOWING], ids=["steps", "updates"])
@pytest.mark.parametrize("status", ["WAITING", "RUNNING"])
def test_an_instant_action_of_ours_that_never_ends_holds_no_order_up(profile: Any, status: str) -> None:
    rig = Rig(profile)

    def stays(said: dict[str, Any]) -> None:
        for action in said["actionStates"]:
            if action["actionType"] in ("startPause", "stopPause", "stateRequest", "factsheetRequest"):
                action["actionStatus"] = status

    reword(rig, stays)
    rig.do(drive("west", "middle", "east"), for_s=5.0)
    rig.do(HOLD, for_s=20.0)
    rig.do(UNHOLD, for_s=120.0)
    assert rig.heard[-1] == WayDone(order=1, node="east")
    assert rig.problems() == []


def test_an_action_of_a_running_order_of_somebody_else_is_waited_for() -> None:
    rig = Rig()
    foreign = {"actionId": "x-1", "actionType": "pick", "actionStatus": "RUNNING"}

    def other(said: dict[str, Any]) -> None:
        if not said["orderId"]:
            said["orderId"] = "somebody"
            said["actionStates"].append(foreign)

    reword(rig, other)
    say(rig)
    rig.do(drive("west", "middle"), for_s=20.0)
    assert rig.orders() == []
    rig.run(90.0)
    assert rig.heard[-1] == WayDone(order=1, node="middle"), "a vehicle that stands is asked all the same"


@pytest.mark.parametrize("profile", [PROFILE, FLOWING], ids=["steps", "updates"])
def test_driving_that_speed_and_position_contradict_is_not_believed(profile: Any) -> None:
    rig = Rig(profile)
    reword(rig, lambda said: said.update(driving=True))
    say(rig)
    rig.do(drive(*TO_CORNER), for_s=250.0)
    assert rig.heard[-1] == WayDone(order=1, node="corner")
    assert rig.problems() == []


def test_driving_that_nothing_contradicts_is_believed() -> None:
    rig = Rig()

    def blind(said: dict[str, Any]) -> None:
        said["driving"] = True
        del said["agvPosition"], said["velocity"]

    reword(rig, blind)
    say(rig)
    rig.do(drive("west", "middle"), for_s=30.0)
    assert rig.orders() == []


def test_a_pick_is_done_although_a_lamp_is_on() -> None:
    rig = Rig()
    rig.run(1.0)
    lamp = {"actionId": "hmi-1", "actionType": "beacon", "actionStatus": "RUNNING"}
    reword(rig, lambda said: said["actionStates"].append(lamp))
    assert rig.do(PICK, for_s=60.0) == [ActionDone(order=5)]
