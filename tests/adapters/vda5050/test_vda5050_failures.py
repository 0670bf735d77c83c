"""What a master cannot deal with by our own fault ends nothing: it is counted, said, and the vehicle's problem until it is over."""

from __future__ import annotations

import logging

import pytest
from vda_rig import Rig
from yard import TO_CORNER, drive

from dray.adapters.vda5050.control.master import FAILED_S, MasterControl
from dray.adapters.vda5050.events import Event, Heard, Woke
from dray.body import NodePassed, ProblemCleared, WayDone
from dray.supervision import Failures

PROBLEM = "our own fault, see the log: {} cannot be dealt with"


class Bug:
    """A bug of ours, as long as it is there: the master cannot deal with one kind of event."""

    def __init__(self, rig: Rig, monkeypatch: pytest.MonkeyPatch, kind: type[Heard | Woke]) -> None:
        self.is_there = True
        self.met = 0
        inner = rig.body.control

        def look(topic: object) -> None:
            self.met += 1
            raise KeyError(topic)

        if kind is Heard:
            hears = inner._hear

            def take(topic: str, data: bytes, now_s: float) -> None:
                hears(topic, data, now_s)
                if self.is_there and topic == "state":
                    look(topic)

            monkeypatch.setattr(inner, "_hear", take)
        else:
            handles = MasterControl.handle

            def handle(control: MasterControl, event: Event, now_s: float) -> object:
                if self.is_there and isinstance(event, Woke):
                    look("time")
                return handles(control, event, now_s)

            monkeypatch.setattr(MasterControl, "handle", handle)


@pytest.fixture
def rig() -> Rig:
    rig = Rig()
    rig.run(5.0)
    rig.body.failures = Failures("Yard/4711")
    return rig


@pytest.mark.parametrize(("kind", "name"), [(Heard, "state"), (Woke, "Woke")])
def test_it_is_counted_said_and_a_problem_and_afterwards_the_vehicle_works(
    rig: Rig,
    kind: type[Heard | Woke],
    name: str,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:
    bug = Bug(rig, monkeypatch, kind)
    with caplog.at_level(logging.ERROR, "dray.supervision"):
        for _ in range(3):
            rig.vehicle.say_state()
            rig.run(5.0)
    assert bug.met > 1
    assert rig.body.failures.counts == {name: bug.met}
    assert rig.problems() == [PROBLEM.format(name)], "it is told once"
    assert rig.body.sense().problem == PROBLEM.format(name), "each heartbeat tells it"
    assert f"Yard/4711: {name} has failed" in caplog.text
    bug.is_there = False
    rig.vehicle.say_state()
    rig.run(10.0)
    assert rig.of(ProblemCleared)
    assert rig.body.sense().problem == ""
    assert any(isinstance(each, WayDone) for each in rig.do(drive(*TO_CORNER), for_s=60.0))


def test_one_of_which_no_other_comes_is_over_after_a_while(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    hears = rig.body.control._hear

    def take(topic: str, data: bytes, now_s: float) -> None:
        if topic == "factsheet":
            raise RecursionError
        hears(topic, data, now_s)

    monkeypatch.setattr(rig.body.control, "_hear", take)
    rig.give("factsheet", b"{}")
    assert rig.body.sense().problem == PROBLEM.format("factsheet")
    rig.run(FAILED_S / 2)
    assert rig.body.sense().problem == PROBLEM.format("factsheet")
    rig.run(FAILED_S)
    assert rig.body.sense().problem == ""


def test_what_was_decided_before_is_said(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    """The vehicle's word of what it has done is reported, though something later in the same step fails."""
    rig.do(drive(*TO_CORNER), for_s=1.0)
    count = len(rig.heard)
    monkeypatch.setattr(rig.body.control, "_note_waits", lambda _now_s: {}["of a bug"])
    rig.run(60.0)
    assert rig.body.failures.total
    assert NodePassed in map(type, rig.heard[count:])


def test_an_instruction_that_fails_is_its_agents_bug(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rig.body.control, "_obey", lambda *_: {}["of a bug"])
    with pytest.raises(KeyError, match="of a bug"):
        rig.body.instruct(drive(*TO_CORNER))
    assert not rig.body.failures.total
