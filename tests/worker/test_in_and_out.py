"""What comes in reaches the agent in order, and what the agent wants is done in order."""

from __future__ import annotations

import asyncio

from agent_stage import KEYS, Cell, Listener, Scripted, Stage, play, say

from dray import messages
from dray.body import CycleDone, StartCycle, WorkcellState
from dray.messages.fact import OrderFulfilled
from dray.protocol.runtime.events import (
    Effect,
    Event,
    Instruct,
    Publish,
    Received,
    Record,
    Reported,
    Send,
    Started,
    Subscribe,
    Unsubscribe,
)
from dray_sim.factory.journal import HeldJournal

# --- what comes in ----------------------------------------------------------------------------------


def test_an_agents_life_begins_with_what_its_body_senses() -> None:
    async def story(stage: Stage) -> None:
        agent = Scripted("M1")
        stage.start(agent, Cell())
        stage.start(bodiless := Scripted("S"))
        await asyncio.sleep(0.001)
        assert agent.events == [
            (0.0, Started(WorkcellState(stock={"made": 0}, seq=0, cycling="", broken="")))
        ]
        assert bodiless.events == [(0.0, Started(None))]

    play(story)


def test_messages_reach_the_agent_with_their_sender_and_the_time() -> None:
    async def story(stage: Stage) -> None:
        agent = Scripted("A1")
        stage.start(agent)
        stranger = stage.network.join("S", lambda *_: None)
        await asyncio.sleep(1.0)
        stranger.send("A1", say(1))
        await asyncio.sleep(1.0)
        _, (at_s, event) = agent.events
        assert event == Received("S", say(1))
        assert 1.0 < at_s < 1.25

    play(story)


def test_all_that_waits_in_the_inbox_is_handled_in_the_order_of_its_coming() -> None:
    async def story(stage: Stage) -> None:
        agent = Scripted("A1")
        stage.start(agent)
        stranger = stage.network.join("S", lambda *_: None)
        await asyncio.sleep(0)
        for number in range(100):
            stranger.send("A1", say(number))
        await asyncio.sleep(1.0)
        assert agent.heard() == [str(number) for number in range(100)]

    play(story)


def test_reports_of_the_body_reach_the_agent_in_order_also_those_given_at_once() -> None:
    def answer(event: Event, _: float) -> list[Effect]:
        return [Instruct(StartCycle("a")), Instruct(StartCycle("b"))] if isinstance(event, Started) else []

    async def story(stage: Stage) -> None:
        agent, cell = Scripted("M1", answer), Cell()
        stage.start(agent, cell)
        await asyncio.sleep(0.001)
        assert cell.instructions == [StartCycle("a"), StartCycle("b")]
        assert [event for _, event in agent.events[1:]] == [
            Reported(CycleDone("1", 1)),
            Reported(CycleDone("2", 2)),
        ]

    play(story)


# --- what goes out ----------------------------------------------------------------------------------


def test_effects_are_carried_out_one_after_another_as_given() -> None:
    def answer(event: Event, _: float) -> list[Effect]:
        if not isinstance(event, Started):
            return []
        return [
            Subscribe("p/k"),
            Publish("p/k", say("heard by itself")),
            Unsubscribe("p/k"),
            Publish("p/k", say("not heard any more")),
            Send("S", say("sent")),
        ]

    async def story(stage: Stage) -> None:
        received: list[messages.Message] = []
        stranger = stage.network.join("S", lambda _, message: received.append(message))
        stranger.subscribe("p/k")
        agent = Scripted("A1", answer)
        stage.start(agent)
        await asyncio.sleep(1.0)
        assert agent.heard() == ["heard by itself"]
        assert received == [say("heard by itself"), say("not heard any more"), say("sent")]

    play(story)


def two_facts_each(event: Event, _: float) -> list[Effect]:
    return [Record(OrderFulfilled("o1")), Record(OrderFulfilled("o2"))] if isinstance(event, Received) else []


def test_facts_are_numbered_published_and_written_down() -> None:
    async def story(stage: Stage) -> None:
        journal = HeldJournal(incarnation=3)
        historian = Listener(stage, KEYS.all_events)
        stage.start(Scripted("A1", two_facts_each), journal=journal)
        await asyncio.sleep(0)
        historian.session.send("A1", say(1))
        historian.session.send("A1", say(2))
        await asyncio.sleep(1.0)
        assert [event.number for event in historian.events] == [1, 2, 3, 4]
        assert {(event.agent, event.incarnation) for event in historian.events} == {("A1", 3)}
        assert [event.fact for event in historian.events[:2]] == [OrderFulfilled("o1"), OrderFulfilled("o2")]
        assert all(0.0 < event.at_s < 1.0 for event in historian.events)
        assert journal.events(3, 1, 100) == historian.events

    play(story)
