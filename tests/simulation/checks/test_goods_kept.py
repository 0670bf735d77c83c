"""Invariant 27: what a dead vehicle has on board is given up by a person's word or after the stated time, and somebody is called for that word."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import msgspec
import pytest
from check_kit import WORK, event, heartbeat, opened

from dray.messages import (
    THING,
    CallState,
    HelpCall,
    MachineCommand,
    MachineCommandKind,
    MachineHeartbeat,
    MachineStatus,
    Message,
    StationHeartbeat,
    StrandedGoods,
    Transport,
    TransportAnswered,
    TransportCancelled,
    TransportState,
)
from dray.messages.fact import MemoryLost, TaskClosed
from dray.messages.heartbeat import TaskBrief
from dray.protocol.takeover.left_aboard import WRITTEN_OFF_AFTER_S
from dray_sim.checks.broken import InvariantBroken
from dray_sim.checks.people.goods_kept import ASKED_WITHIN_S, GoodsCalledFor, GoodsKept
from dray_sim.factory.sim_factory import SimFactory

TASK = "T-9-1"
GOODS = msgspec.structs.replace(WORK, item="pump-p3", goal="G8")
A_THING = msgspec.structs.replace(WORK, item=THING, quantity=1, sources=("M8",), destination="S1")


class Dead:
    """ATV2 has died with a load on board, at 100 s."""

    def __init__(self, work: Transport) -> None:
        body = SimpleNamespace(off=True, sense=lambda: SimpleNamespace(load=work.item))
        self.check = GoodsKept(cast(SimFactory, SimpleNamespace(vehicles={"ATV2": body})))
        self.hears(10.0, "S1", event("S1", opened(TASK, work)))
        self.hears(100.0, "ATV2", heartbeat("ATV2", TASK))

    def hears(self, at_s: float, sender: str, message: Message) -> None:
        self.check.on_message(at_s, sender, "*", message)

    def given_up(self, after_s: float) -> None:
        gone = TaskClosed(task=TASK, epoch=1, outcome="withdrawn", carrier="ATV2")
        self.hears(100.0 + after_s, "S1", event("S1", gone))


@pytest.mark.parametrize("work", [GOODS, A_THING], ids=["goods", "a thing"])
def test_what_is_given_up_without_a_word_before_its_time_is_noticed(work: Transport) -> None:
    Dead(work).given_up(WRITTEN_OFF_AFTER_S)
    with pytest.raises(InvariantBroken, match="T-9-1 was given up with its load on board of ATV2"):
        Dead(work).given_up(WRITTEN_OFF_AFTER_S - 1.0)


def test_material_lies_elsewhere_too() -> None:
    Dead(WORK).given_up(1.0)


@pytest.mark.parametrize(
    "word",
    [
        MachineCommand(command="C1", kind=MachineCommandKind.WRITE_OFF, task=TASK, issued_by="Maria"),
        TransportCancelled("T-9"),
    ],
    ids=["written off", "called off"],
)
def test_by_somebodys_word_it_may_be_given_up(word: Message) -> None:
    dead = Dead(A_THING)
    dead.hears(110.0, "gateway", word)
    dead.given_up(20.0)


def test_what_was_called_off_too_late_may_not() -> None:
    dead = Dead(A_THING)
    dead.hears(110.0, "gateway", TransportCancelled("T-9"))
    dead.hears(110.1, "S1", TransportAnswered("T-9", TransportState.ON_BOARD))
    with pytest.raises(InvariantBroken):
        dead.given_up(20.0)


def test_who_has_lost_its_memory_may_give_up_what_it_does_not_know() -> None:
    dead = Dead(A_THING)
    dead.hears(110.0, "S1", event("S1", MemoryLost(reason="damaged")))
    dead.given_up(20.0)


def test_by_a_word_about_another_one_it_may_not() -> None:
    dead = Dead(A_THING)
    dead.hears(110.0, "gateway", TransportCancelled("T-90"))
    with pytest.raises(InvariantBroken):
        dead.given_up(20.0)


def told(place: str) -> MachineHeartbeat | StationHeartbeat:
    """What a place tells of a thing that waits."""
    left = StrandedGoods(atv="ATV2", node="a1", until_s=1000.0)
    brief = TaskBrief(
        task=TASK,
        epoch=1,
        item=THING,
        quantity=1,
        source="M8",
        destination=place,
        deadline_s=600.0,
        primary="ATV2",
        stranded=left,
    )
    common: dict[str, Any] = {"incarnation": 1, "seq": 1, "at_s": 0.0, "tasks": (brief,)}
    if place == "S1":
        return StationHeartbeat(station=place, **common)
    return MachineHeartbeat(machine=place, status=MachineStatus.IDLE, **common)


@pytest.mark.parametrize("place", ["M7", "S1"])
def test_a_place_that_calls_nobody_for_what_waits_is_noticed(place: str) -> None:
    check = GoodsCalledFor()
    check.on_message(10.0, place, "*", told(place))
    call = HelpCall(
        call="H1",
        caller=place,
        incarnation=1,
        number=1,
        at_s=50.0,
        state=CallState.ASKING,
        since_s=50.0,
        goods=TASK,
    )
    check.on_message(50.0, place, "*", call)
    check.on_message(50.0 + ASKED_WITHIN_S, place, "*", told(place))
    with pytest.raises(InvariantBroken, match=f"{place} has T-9-1 on board of a failed vehicle for 61 s"):
        check.on_message(51.0 + ASKED_WITHIN_S, place, "*", told(place))
