"""What is said again until it is answered."""

from __future__ import annotations

from msgspec.structs import replace
from spoken import accepted

from dray.messages import Docked, WorkSought
from dray.protocol.runtime.events import NEVER_S, Publish, Send
from dray.protocol.runtime.life import Life
from dray.protocol.runtime.retransmission import ASK_AGAIN_S, Retransmitter

DOCKED = Send("S1", Docked(task="T1", epoch=1, station="S1"))
ONE, OTHER = Send("STRATEGIST", accepted("G1")), Send("STRATEGIST", accepted("G1", number=2))


def said(send: Send, at_s: float) -> Send:
    """The same, as it is said at a time."""
    return Send(send.to, replace(send.message, at_s=at_s))


def test_it_is_said_at_once_and_again_and_again_until_it_is_settled() -> None:
    life = Life()
    asked = Retransmitter("confirm", life)
    asked.say("G1", ONE, 0.0)
    assert "G1" in asked
    for again in range(1, 4):
        assert life.timers.next_s == again * ASK_AGAIN_S
        assert life.timers.due(life.timers.next_s) == [("confirm", "G1")]
        asked.wake("G1", again * ASK_AGAIN_S)
    assert life.effects == [said(ONE, again * ASK_AGAIN_S) for again in range(4)]
    asked.settle("G1")
    assert "G1" not in asked
    assert life.timers.next_s == NEVER_S


def test_what_is_said_last_about_a_task_is_what_is_repeated() -> None:
    life = Life()
    asked = Retransmitter("confirm", life)
    asked.say("G1", ONE, 0.0)
    asked.say("G1", OTHER, 1.0)
    asked.wake("G1", 4.0)
    assert life.effects == [said(ONE, 0.0), said(OTHER, 1.0), said(OTHER, 4.0)]


def test_settling_or_waking_for_nothing_is_harmless() -> None:
    life = Life()
    asked = Retransmitter("confirm", life)
    asked.settle("G1")
    asked.wake("G1", 0.0)
    assert life.effects == []


def test_with_a_bound_it_is_said_so_often_and_no_more() -> None:
    life = Life()
    asked = Retransmitter("ask", life, every_s=5.0, most=3)
    asked.say("T1", DOCKED, 0.0)
    for now_s in (5.0, 10.0, 15.0):
        assert life.timers.due(now_s) == [("ask", "T1")]
        asked.wake("T1", now_s)
    assert life.effects == [DOCKED] * 3
    assert asked.is_exhausted("T1")
    assert life.timers.next_s == NEVER_S


def test_the_same_said_by_hand_counts_and_something_else_begins_anew() -> None:
    life = Life()
    asked = Retransmitter("ask", life, most=2)
    asked.say("T1", DOCKED, 0.0)
    asked.say("T1", DOCKED, 3.0)
    assert asked.is_exhausted("T1")
    asked.say("T1", Send("S1", Docked(task="T1", epoch=2, station="S1")), 6.0)
    assert not asked.is_exhausted("T1")


def test_who_is_asked_to_wait_asks_later_and_as_often_as_before() -> None:
    life = Life()
    asked = Retransmitter("ask", life, most=2)
    asked.say("T1", DOCKED, 0.0)
    asked.wake("T1", 3.0)
    asked.defer("T1", 9.0)
    assert not asked.is_exhausted("T1")
    assert life.timers.next_s == 9.0
    asked.wake("T1", 9.0)
    asked.wake("T1", 12.0)
    assert asked.is_exhausted("T1")
    assert life.effects == [DOCKED] * 4


def test_what_nobody_waits_for_is_not_put_off() -> None:
    life = Life()
    asked = Retransmitter("ask", life)
    asked.defer("T1", 9.0)
    assert life.timers.next_s == NEVER_S


def test_what_is_said_to_whoever_listens_is_repeated_too() -> None:
    life = Life()
    sought = Publish("plant/free/ATV1", WorkSought(atv="ATV1", abilities=()))
    asked = Retransmitter("ask", life)
    asked.say("ATV1", sought, 0.0)
    asked.wake("ATV1", 3.0)
    assert life.effects == [sought, sought]
