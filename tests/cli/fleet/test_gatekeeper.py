"""The person at the gate of `real_bodies`: what it says counts once, whatever answers are lost."""

from __future__ import annotations

import json
from typing import Any, cast

import httpx
from fleets import Fleet
from real_bodies import Gatekeeper

from dray.adapters.people.gate import PeopleGate
from dray.body import Admit, Report, Word, WordTaken
from dray.messages import MachineCommandKind


class Gate:
    """A gateway with a gate of people behind it, in one.

    Attributes:
        lost: for each request to come, whether its answer is lost; those after the last one are answered.
    """

    def __init__(self, *lost: bool) -> None:
        self.lost = list(lost)
        self.body = PeopleGate(self)
        self._reports: list[Report] = []
        self.body.attach(self._reports.append)

    def remember(self, kept: object) -> None:
        """It is not started again."""

    def admit(self, goal: str, pieces: int) -> None:
        self.body.instruct(Admit(goal, pieces))

    def gateway(self) -> httpx.Client:
        return httpx.Client(base_url="http://gateway", transport=httpx.MockTransport(self._answer))

    def _answer(self, request: httpx.Request) -> httpx.Response:
        asked: dict[str, Any] = json.loads(request.content)
        kind = MachineCommandKind(asked["kind"])
        self.body.instruct(Word(asked["command"], kind, asked["item"], asked["quantity"], sure=asked["sure"]))
        [*_, taken] = self._reports
        assert isinstance(taken, WordTaken)
        if self.lost and self.lost.pop(0):
            return httpx.Response(504)
        reason = None if taken.refused is None else taken.refused.value
        return httpx.Response(200, json={"done": reason is None, "reason": reason, "detail": taken.detail})


def keeper_at(gate: Gate) -> Gatekeeper:
    return Gatekeeper(cast(Fleet, gate))


def test_it_has_not_said_what_is_not_answered_though_the_gate_has_counted_it() -> None:
    gate = Gate(True)
    gate.admit("O-1.1", 6)
    keeper = keeper_at(gate)
    keeper.look({"O-1.1": 6})
    assert gate.body.sense().arrived == {"O-1.1": 6}
    assert not keeper.has_said({"O-1.1": 6})
    keeper.look({"O-1.1": 6})
    assert keeper.has_said({"O-1.1": 6})
    assert gate.body.sense().arrived == keeper.said == {"O-1.1": 6}


def test_its_first_word_is_answered_twice_whatever_is_lost_and_counts_once() -> None:
    gate = Gate(True, False, True)
    gate.admit("O-1.1", 6)
    keeper = keeper_at(gate)
    for _ in range(3):
        keeper.look({"O-1.1": 2})
    assert (keeper.said, keeper.again) == ({"O-1.1": 2}, 1)
    keeper.look({"O-1.1": 6})
    assert (keeper.said, keeper.again) == ({"O-1.1": 6}, 1)
    assert gate.body.sense().arrived == {"O-1.1": 6}


def test_what_lies_there_and_was_not_said_is_seen() -> None:
    gate = Gate()
    gate.admit("O-1.1", 6)
    keeper = keeper_at(gate)
    keeper.look({"O-1.1": 2})
    assert keeper.has_said({"O-1.1": 2, "O-1.2": 0})
    assert not keeper.has_said({"O-1.1": 3})


def test_pieces_that_are_admitted_no_more_are_surplus_and_the_others_count() -> None:
    gate = Gate(True)
    gate.admit("O-1.1", 2)
    keeper = keeper_at(gate)
    lie_there = {"O-1.1": 3, "O-1.2": 1}
    for _ in range(3):
        keeper.look(lie_there)
    assert (keeper.said, keeper.surplus) == ({"O-1.1": 2}, {"O-1.1": 1, "O-1.2": 1})
    assert keeper.has_said(lie_there)
