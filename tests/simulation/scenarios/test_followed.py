"""Whoever follows a scenario, has missed something and asks for it again, as a busy gateway does, changes nothing of how it is judged."""

from __future__ import annotations

import asyncio
import dataclasses

import pytest

from dray.messages import Event, EventsAsked, EventsKept, Message
from dray.messages.history import EVENTS_PER_ANSWER
from dray_sim.network.listeners import Listeners
from dray_sim.run.evidence import HELD
from dray_sim.run.stage import Played, Stage, with_right_of_way
from dray_sim.scenarios.paper import case_6

ASKED_EVERY_S = 30.0

LASTS_S = 1500.0
"""The first goods have been delivered by then, and have been asked for again."""


async def miss_everything(stage: Stage) -> int:
    """Ask all agents for all of their history, again and again; how many facts they have told again."""
    told: list[Message] = []
    gateway = stage.factory.bus.join("gateway", lambda _sender, message: told.append(message))
    while stage.now_s() < LASTS_S:
        await asyncio.sleep(ASKED_EVERY_S)
        for agent in (*stage.factory.vehicles, *stage.factory.workcells, *stage.factory.strategists):
            gateway.send(agent, EventsAsked(incarnation=1, first=1, last=EVENTS_PER_ANSWER))
    assert stage.observer.delivered, "nothing was delivered that could be told again"
    assert any(isinstance(each, EventsKept) for each in told)
    return sum(isinstance(each, Event) for each in told)


def play() -> Played[int]:
    part = dataclasses.replace(case_6.PART, script=miss_everything)
    with with_right_of_way(on=True):
        return part.play(1)


def test_what_is_told_again_is_no_second_delivery() -> None:
    played = play()
    assert played.invariants == HELD
    assert played.result is not None
    assert played.result > 1_000


def test_counted_as_news_it_would_break_the_first_invariant_that_counts(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def all_is_news(self: Listeners, at_s: float, sender: str, address: str, message: Message) -> None:
        for listener in self._listeners:
            listener.on_message(at_s, sender, address, message)

    monkeypatch.setattr(Listeners, "on_message", all_is_news)
    assert "delivered twice" in play().invariants
