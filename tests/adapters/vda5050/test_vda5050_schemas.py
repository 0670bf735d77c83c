"""Every message of both sides is as the official schemas of its version say."""

from __future__ import annotations

from typing import Any

import msgspec
import pytest
from official_schemas import MISSING, folder, objections
from vda_rig import FLOWING, Rig
from yard import HOLD, PICK, TO_CORNER, UNHOLD, drive

from dray.body import Charge, Drive, Drop
from dray_sim.vda5050.misbehaviour import Misbehaviour

QUIRKS = (
    Misbehaviour(),
    Misbehaviour(no_pose_in_state=True, busy_after_s=1.5, no_loads=True),
    Misbehaviour(actions_twice=True, keeps_node_states=True, cancel_s=4.0, lingering_warnings=True),
)


@pytest.mark.parametrize("quirks", QUIRKS, ids=["honest", "odd", "odder"])
@pytest.mark.parametrize("version", ["2.0", "2.1", "3.0"])
def test_every_message_of_both_sides_is_as_the_schemas_say(version: Any, quirks: Misbehaviour) -> None:
    if folder() is None:
        pytest.skip(MISSING)
    rig = Rig(msgspec.structs.replace(FLOWING, version=version, horizon=2), quirks)
    rig.run(1.0)
    rig.do(PICK, for_s=3.0)
    rig.do(drive("west", "middle", order=6), for_s=60.0)
    rig.do(Drive(order=7, nodes=("middle", "west"), released=2), for_s=60.0)
    rig.do(msgspec.structs.replace(PICK, order=8), for_s=60.0)
    rig.do(drive(*TO_CORNER, order=9), for_s=15.0)
    rig.do(HOLD, for_s=5.0)
    rig.do(UNHOLD, for_s=150.0)
    rig.do(Drop(order=10, station="DELIVERY"), for_s=60.0)
    rig.do(Charge(order=11, charger="CH2"), for_s=30.0)
    rig.do(Drive(order=12, nodes=("corner", "north"), released=1), for_s=10.0)
    rig.do(Drive(order=13, nodes=("corner", "north"), released=2), for_s=20.0)
    rig.vehicle.restart()
    rig.run(30.0)
    topics = {(who, topic) for _, who, topic, _ in rig.wire}
    assert {("us", "order"), ("us", "instantActions"), ("it", "state"), ("it", "connection")} <= topics
    said = {action["actionType"] for one in rig.said("instantActions") for action in one["actions"]}
    assert {
        "startPause",
        "stopPause",
        "cancelOrder",
        "stopCharging",
        "stateRequest",
        "factsheetRequest",
    } <= said
    wrong = [
        (who, objection) for _, who, topic, said in rig.wire for objection in objections(version, topic, said)
    ]
    assert wrong == []
