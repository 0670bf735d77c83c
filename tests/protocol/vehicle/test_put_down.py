"""A vehicle goes on telling of a load that it has put down, also after it has gone on to other work."""

from __future__ import annotations

import pytest
from atv1 import handing_over, unloading
from effects import committed, sent
from rigs import VehicleRig
from spoken import award

from dray.messages import (
    Accepted,
    AtvHeartbeat,
    DockOpened,
    Handover,
    HandoverAccepted,
    Message,
    Reason,
    Release,
    Role,
    Superseded,
    Withdrawn,
)
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


def test_a_release_answers_no_handover() -> None:
    rig = handing_over()
    [job] = [rig.agent._contracts.job]
    assert job is not None
    rig.on_message("M8", Release("M8-1", 1, Role.PRIMARY, Reason.TASK_ENDED, number=job.number))
    assert rig.agent._contracts.job is None
    assert tells(rig)
    rig.on_message("M8", Superseded("M8-1", 2))
    assert tells(rig) == []


def dropping() -> VehicleRig:
    rig = unloading()
    rig.on_message("M8", DockOpened(task="M8-1", epoch=1, station="M8"))
    return rig


def test_it_tells_of_what_it_has_put_down_although_it_was_superseded_meanwhile() -> None:
    rig = dropping()
    rig.on_message("M8", Superseded("M8-1", 2))
    rig.dropped()
    assert tells(rig)
    rig.on_message("M8", Superseded("M8-1", 2))
    assert tells(rig) == []


def next_life(before: VehicleRig, *, load: tuple[str, int] = ("shaft", 24), node: str = "") -> VehicleRig:
    """ATV1 is started again, with its notes; its body may unload still for its earlier life."""
    rig = VehicleRig(node=node or before.node, incarnation=before.agent.incarnation + 1)
    rig.memory, rig.now_s, rig.load = committed(before.all), before.now_s, load
    rig.start()
    return rig


def goes_down(rig: VehicleRig, *, node: str = "") -> None:
    """Its body has put the load down."""
    rig.load, rig.node = ("", 0), node or rig.node
    rig.run(rig.now_s + 6.0)
    assert rig.heartbeats(AtvHeartbeat)[-1].task is None


def test_it_tells_of_what_its_body_puts_down_for_an_earlier_life_although_it_is_superseded() -> None:
    rig = next_life(dropping())
    rig.on_message("M8", Superseded("M8-1", 2))
    goes_down(rig)
    assert tells(rig)


def test_so_does_the_life_after_that() -> None:
    before = next_life(dropping())
    before.on_message("M8", Superseded("M8-1", 2))
    rig = next_life(before)
    goes_down(rig)
    assert tells(rig)
    assert tells(next_life(before, load=("", 0)))


def test_it_does_not_tell_of_a_load_that_is_gone_elsewhere() -> None:
    rig = next_life(dropping())
    rig.on_message("M8", Superseded("M8-1", 2))
    goes_down(rig, node="p3")
    assert tells(rig) == []
    before = next_life(dropping())
    before.on_message("M8", Superseded("M8-1", 2))
    assert tells(next_life(before, load=("", 0), node="p3")) == []
