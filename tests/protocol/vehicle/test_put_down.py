"""A vehicle goes on telling of a load that it has put down, also after it has gone on to other work."""

from __future__ import annotations

import pytest
from atv1 import handing_over
from effects import committed, sent
from rigs import VehicleRig
from spoken import award

from dray.messages import Accepted, Handover, HandoverAccepted, Message, Superseded, Withdrawn
from dray.protocol.runtime.retransmission import ASK_AGAIN_S
from dray.protocol.vehicle.job.job_messages import GIVE_UP_AFTER
from dray.protocol.vehicle.put_down import TELLS

LEFT_S = (GIVE_UP_AFTER + 1) * ASK_AGAIN_S


def left_alone() -> VehicleRig:
    """ATV1 has put its load down at M8, which does not answer; it is free again."""
    rig = handing_over()
    rig.run(rig.now_s + LEFT_S)
    assert rig.agent._contracts.job is None
    return rig


def tells(rig: VehicleRig, for_s: float = 2 * ASK_AGAIN_S) -> list[Handover]:
    """What it tells M8 of its load in a while."""
    return sent(rig.run(rig.now_s + for_s), Handover, to="M8")


@pytest.mark.parametrize(
    "answer",
    [HandoverAccepted("M8-1", 1), Superseded("M8-1", 2), Withdrawn("M8-1", 1)],
    ids=lambda answer: type(answer).__name__,
)
def test_it_tells_until_the_coordinator_has_answered(answer: Message) -> None:
    rig = left_alone()
    [told, *_] = sent(rig.all, Handover, to="M8")
    assert set(tells(rig)) == {told}
    rig.on_message("M8", answer)
    assert tells(rig) == []


def test_another_s_answer_changes_nothing() -> None:
    rig = left_alone()
    rig.on_message("M9", HandoverAccepted("M8-1", 1))
    rig.on_message("M8", HandoverAccepted("M8-1", 2))
    assert tells(rig)


def test_it_tells_while_it_does_other_work() -> None:
    rig = left_alone()
    assert sent(rig.on_message("M9", award(task="M9-1")), Accepted)
    assert tells(rig)


def test_it_tells_no_more_of_a_task_that_it_does_again() -> None:
    rig = left_alone()
    assert sent(rig.on_message("M8", award(epoch=2)), Accepted)
    assert tells(rig) == []


def test_it_tells_in_its_next_life() -> None:
    before = left_alone()
    rig = VehicleRig(incarnation=2)
    rig.memory, rig.now_s = committed(before.all), before.now_s
    rig.start()
    assert tells(rig)


def test_it_does_not_tell_for_ever() -> None:
    rig = left_alone()
    assert tells(rig, TELLS * ASK_AGAIN_S)
    assert tells(rig) == []
