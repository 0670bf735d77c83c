"""Whoever is not believed hears why, and so does history: once a minute."""

from __future__ import annotations

import pytest
from atv1 import parked
from defaults import PLANT, SOME_TIME_S
from effects import facts, published, sent
from m7 import NO_HOUSINGS, m7
from msgspec.structs import replace
from spoken import award, bid, rhb, transport

from dray.messages import (
    Accepted,
    Bid,
    Disbelieved,
    HelpWanted,
    Implausible,
    Reason,
    Release,
    Role,
    TakenOver,
    TaskAnnounced,
)
from dray.messages.fact import CarrierChanged, NotBelieved, WordDisbelieved
from dray.messages.people.command import PROMISE_MAX_S
from dray.protocol.contract_net.task import StandbyContract
from dray.protocol.contract_net.trust.assessment import Assessor
from dray.protocol.liveness.failure_detector import FailureDetector
from dray.protocol.runtime.events import Effect, Ignore
from dray.protocol.runtime.life import Life
from dray.protocol.runtime.throttle import TOLD_EVERY_S

NOW_S = 5000.0


def by_clock(ahead_s: float) -> Bid:
    return replace(bid(200.0, finish_s=NOW_S + ahead_s + 260.0), at_s=NOW_S + ahead_s)


@pytest.mark.parametrize("ahead_s", [3600.0, -1.9e9])
def test_a_bid_by_a_wrong_clock_is_refused_and_its_bidder_hears_by_how_much(ahead_s: float) -> None:
    life = Life()
    assert Assessor(PLANT, life).refuses("ATV1", transport(), by_clock(ahead_s), NOW_S)
    [told] = sent(life.effects, Disbelieved, to="ATV1")
    assert (told.task, told.reason) == ("T1", Implausible.CLOCK)
    assert told.clock_ahead_s == pytest.approx(ahead_s)
    [fact] = facts(life.effects, WordDisbelieved)
    assert (fact.contractor, fact.task, fact.clock_ahead_s) == ("ATV1", "T1", told.clock_ahead_s)
    assert [each.reason for each in life.effects if isinstance(each, Ignore)] == [Implausible.CLOCK]


def test_whoever_is_not_believed_is_told_once_a_minute() -> None:
    life = Life()
    assessor = Assessor(PLANT, life)
    for second in range(int(TOLD_EVERY_S) + 1):
        offer = replace(by_clock(3600.0), at_s=NOW_S + 3600.0 + second)
        assert assessor.refuses("ATV1", transport(), offer, NOW_S + second)
    assert assessor.refuses("ATV2", transport(), by_clock(3600.0), NOW_S)
    assert (
        len(sent(life.effects, Disbelieved, to="ATV1")) == len(facts(life.effects, WordDisbelieved)) - 1 == 2
    )
    assert len(sent(life.effects, Disbelieved, to="ATV2")) == 1


def test_an_acceptance_by_a_wrong_clock_makes_no_contract_and_the_next_one_is_asked() -> None:
    rig = m7(NO_HOUSINGS, goal=24)
    [announced] = [each for each in sent_to_all(rig.all) if each.task == "M7-1"]
    for atv, cost_s in (("ATV1", 60.0), ("ATV2", 90.0)):
        rig.on_message(atv, bid(cost_s, task="M7-1", source=announced.work.sources[0]))
    effects = rig.run(announced.bids_until_s)
    [asked] = [effect for effect in effects if getattr(getattr(effect, "message", None), "number", 0)]
    assert asked.to == "ATV1"
    wrong = Accepted(
        "M7-1", 1, Role.PRIMARY, rig.now_s + 3660.0, asked.message.number, at_s=rig.now_s + 3600.0
    )
    effects = rig.on_message("ATV1", wrong)
    assert [each.reason for each in sent(effects, Release, to="ATV1")] == [Reason.CLOCK_WRONG]
    assert len(sent(effects, Disbelieved, to="ATV1")) == 1
    assert [effect.to for effect in effects if getattr(getattr(effect, "message", None), "work", None)] == [
        "ATV2"
    ]


def test_a_promise_by_a_clock_that_is_a_little_wrong_is_understood_by_ours() -> None:
    rig = m7(NO_HOUSINGS, goal=24)
    [announced] = [each for each in sent_to_all(rig.all) if each.task == "M7-1"]
    rig.on_message("ATV1", bid(60.0, task="M7-1", source=announced.work.sources[0]))
    rig.run(announced.bids_until_s)
    ahead_s = 120.0
    rig.on_message(
        "ATV1", Accepted("M7-1", 1, Role.PRIMARY, rig.now_s + ahead_s + 70.0, 1, at_s=rig.now_s + ahead_s)
    )
    [task] = [task for task in rig.agent._flow.tasks if task.id == "M7-1"]
    assert task.primary == "ATV1"
    assert task.contract.promised_s == pytest.approx(rig.now_s + 70.0)


def test_a_takeover_by_a_wrong_clock_is_refused() -> None:
    rig = m7(NO_HOUSINGS, goal=24)
    rig.hire("M7-1", "ATV1")
    [task] = [task for task in rig.agent._flow.tasks if task.id == "M7-1"]
    task.standby = StandbyContract("ATV2")
    rig.now_s += 60.0
    said = TakenOver("M7-1", 2, "ATV1", Reason.SILENT, rig.now_s - 3600.0 + 80.0, at_s=rig.now_s - 3600.0)
    effects = rig.on_message("ATV2", said)
    assert [each.reason for each in sent(effects, Release, to="ATV2")] == [Reason.CLOCK_WRONG]
    assert facts(effects, CarrierChanged) == []
    assert task.primary == "ATV1"


def test_a_vehicle_that_is_not_believed_writes_it_down_once_a_minute_and_goes_on() -> None:
    rig = parked()
    said = Disbelieved(task="M8-1", epoch=1, reason=Implausible.CLOCK, clock_ahead_s=3600.0)
    effects = [each for _ in range(5) for each in rig.on_message("M8", said)]
    assert facts(effects, NotBelieved) == [NotBelieved(by="M8", task="M8-1", reason=said.reason)]
    assert len(facts(rig.on_message("M7", said), NotBelieved)) == 1
    rig.on_message("M8", award())
    assert rig.agent._contracts.job is not None


# --- help, by another clock ----------------------------------------------------------------------


@pytest.mark.parametrize("ahead_s", [0.0, 3600.0, -3600.0, -1.9e9])
def test_the_time_for_help_is_what_its_own_clock_has_left(ahead_s: float) -> None:
    detector = FailureDetector("ATV1", 1.0, 0.0)
    wanted = HelpWanted(until_s=100.0 + ahead_s + 60.0)
    for second in range(59):
        beat = replace(rhb("ATV1", second + 1, 100.0 + second + ahead_s, task="T1"), help=wanted)
        detector.on_heartbeat(beat, 100.0 + second)
        assert detector.failure(100.0 + second) is None
    beat = replace(rhb("ATV1", 61, 161.0 + ahead_s, task="T1"), help=wanted)
    detector.on_heartbeat(beat, 161.0)
    assert detector.failure(161.0) == Reason.IN_ERROR


def test_nobody_buys_time_with_a_call_for_help_that_never_ends() -> None:
    detector = FailureDetector("ATV1", 1.0, 0.0)
    beat = replace(rhb("ATV1", 1, 0.0, task="T1"), help=HelpWanted(until_s=SOME_TIME_S))
    detector.on_heartbeat(beat, 0.0)
    assert detector.fails_at_s <= PROMISE_MAX_S


def sent_to_all(effects: list[Effect]) -> list[TaskAnnounced]:
    return published(effects, TaskAnnounced)
