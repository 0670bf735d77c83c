"""What is said again until it is answered."""

from __future__ import annotations

from kit import accepted
from msgspec.structs import replace

from dray.protocol.runtime.events import NEVER_S, Effect, Send
from dray.protocol.runtime.retransmission import ASK_AGAIN_S, Retransmitter
from dray.protocol.runtime.timers import Timers

ONE, OTHER = Send("STRATEGIST", accepted("G1")), Send("STRATEGIST", accepted("G1", number=2))


def said(send: Send, at_s: float) -> Send:
    """The same, as it is said at a time."""
    return Send(send.to, replace(send.message, at_s=at_s))


def test_it_is_said_at_once_and_again_and_again_until_it_is_settled() -> None:
    out: list[Effect] = []
    timers = Timers()
    insistence = Retransmitter("confirm", timers, out)
    insistence.say("G1", ONE.to, ONE.message, 0.0)
    assert "G1" in insistence
    for again in range(1, 4):
        assert timers.next_s == again * ASK_AGAIN_S
        assert timers.due(timers.next_s) == [("confirm", "G1")]
        insistence.wake("G1", again * ASK_AGAIN_S)
    assert out == [said(ONE, again * ASK_AGAIN_S) for again in range(4)]
    insistence.settle("G1")
    assert "G1" not in insistence
    assert timers.next_s == NEVER_S


def test_what_is_said_last_about_a_task_is_what_is_repeated() -> None:
    out: list[Effect] = []
    insistence = Retransmitter("confirm", Timers(), out)
    insistence.say("G1", ONE.to, ONE.message, 0.0)
    insistence.say("G1", OTHER.to, OTHER.message, 1.0)
    insistence.wake("G1", 4.0)
    assert out == [said(ONE, 0.0), said(OTHER, 1.0), said(OTHER, 4.0)]


def test_settling_or_waking_for_nothing_is_harmless() -> None:
    out: list[Effect] = []
    insistence = Retransmitter("confirm", Timers(), out)
    insistence.settle("G1")
    insistence.wake("G1", 0.0)
    assert out == []
