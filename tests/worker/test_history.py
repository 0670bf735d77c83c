"""What a worker tells again of its agent's history, and what it remembers for the next life."""

from __future__ import annotations

import asyncio

import pytest
from agent_stage import Cell, Listener, Scripted, Stage, play, say

from dray import messages
from dray.body import Instruction, StartCycle
from dray.errors import ProtocolViolation
from dray.memory import WHOLE, AtvMemory, EndedOrder
from dray.messages import EventsAsked, EventsKept
from dray.messages.fact import OrderFulfilled
from dray.messages.history import EVENTS_PER_ANSWER, LifeKept
from dray.protocol.runtime.events import (
    Commit,
    Effect,
    Event,
    Instruct,
    Record,
    Send,
    Started,
)
from dray_sim.factory.journal import HeldJournal

# --- what is told again -----------------------------------------------------------------------------


async def with_a_history(stage: Stage, facts: int, journal: HeldJournal) -> Scripted:
    """An agent in its third life that has recorded that many facts in it."""

    def answer(event: Event, _: float) -> list[Effect]:
        return [Record(OrderFulfilled(f"o{number}")) for number in range(1, facts + 1)]

    agent = Scripted("A1", answer)
    stage.start(agent, journal=journal)
    await asyncio.sleep(1.0)
    return agent


def test_what_somebody_missed_is_told_to_that_one_alone_and_the_agent_is_not_asked() -> None:
    async def story(stage: Stage) -> None:
        agent = await with_a_history(stage, 10, HeldJournal(incarnation=3))
        historian, eavesdropper = Listener(stage), Listener(stage, "**", name="E")
        historian.session.send("A1", EventsAsked(incarnation=3, first=4, last=7))
        await asyncio.sleep(1.0)
        assert [event.number for event in historian.events] == [4, 5, 6, 7]
        assert historian.events[0].fact == OrderFulfilled("o4")
        assert historian.others == [EventsKept(incarnation=3, first=1, last=10, life=3, earlier=())]
        assert eavesdropper.events == eavesdropper.others == []
        assert len(agent.events) == 1

    play(story)


def test_an_answer_is_bounded_and_tells_how_far_asking_again_will_lead() -> None:
    async def story(stage: Stage) -> None:
        await with_a_history(stage, EVENTS_PER_ANSWER + 5, HeldJournal(incarnation=3))
        historian = Listener(stage)
        historian.session.send("A1", EventsAsked(incarnation=3, first=3, last=2**53))
        await asyncio.sleep(1.0)
        assert [event.number for event in historian.events] == list(range(3, EVENTS_PER_ANSWER + 3))
        assert historian.others == [
            EventsKept(incarnation=3, first=1, last=EVENTS_PER_ANSWER + 5, life=3, earlier=())
        ]

    play(story)


def test_what_a_journal_has_forgotten_is_said_to_be_gone() -> None:
    async def story(stage: Stage) -> None:
        await with_a_history(stage, 10, HeldJournal(incarnation=3, events_kept=4))
        historian = Listener(stage)
        historian.session.send("A1", EventsAsked(incarnation=3, first=1, last=8))
        historian.session.send("A1", EventsAsked(incarnation=2, first=1, last=8))
        await asyncio.sleep(1.0)
        assert [event.number for event in historian.events] == [7, 8]
        assert historian.others == [
            EventsKept(incarnation=3, first=7, last=10, life=3, earlier=()),
            EventsKept(incarnation=2, first=1, last=0, life=3, earlier=()),
        ]

    play(story)


def test_a_life_tells_what_the_one_before_it_has_seen() -> None:
    async def story(stage: Stage) -> None:
        journal = HeldJournal(incarnation=2)
        journal.write([messages.Event("A1", 2, 1, 0.0, OrderFulfilled("before"))], {})
        journal.begin_life()
        await with_a_history(stage, 1, journal)
        historian = Listener(stage)
        historian.session.send("A1", EventsAsked(incarnation=2, first=1, last=9))
        await asyncio.sleep(1.0)
        assert [event.fact for event in historian.events] == [OrderFulfilled("before")]
        earlier = (LifeKept(incarnation=2, first=1, last=1),)
        assert historian.others == [EventsKept(incarnation=2, first=1, last=1, life=3, earlier=earlier)]

    play(story)


# --- what is remembered -----------------------------------------------------------------------------


def test_a_step_is_written_down_as_a_whole_before_any_of_it_is_told() -> None:
    journal = HeldJournal(incarnation=3)
    seen: list[tuple[object, list[messages.AnyFact]]] = []

    def answer(event: Event, _: float) -> list[Effect]:
        return [
            Send("H", say("first of all")),
            Instruct(StartCycle("a")),
            Record(OrderFulfilled("o1")),
            Commit(AtvMemory(speed_frac=0.5)),
            Record(OrderFulfilled("o2")),
        ]

    class Watchful(Cell):
        def instruct(self, instruction: Instruction) -> None:
            seen.append((journal.memory, [event.fact for event in journal.events(3, 1, 9)]))

    async def story(stage: Stage) -> None:
        stranger = Listener(stage, "**")
        stage.start(Scripted("M1", answer), Watchful(), journal)
        await asyncio.sleep(1.0)
        assert seen == [({WHOLE: AtvMemory(speed_frac=0.5)}, [OrderFulfilled("o1"), OrderFulfilled("o2")])]
        assert stranger.events == journal.events(3, 1, 9)

    play(story)


def test_what_was_written_is_told_to_the_next_life() -> None:
    def answer(event: Event, _: float) -> list[Effect]:
        notes = [Commit(AtvMemory(speed_frac=frac)) for frac in (0.1, 0.2)]
        return [*notes, Commit(EndedOrder(), "O-1"), Commit(EndedOrder(), "O-2"), Commit(None, "O-1")]

    async def story(stage: Stage) -> None:
        journal = HeldJournal()
        first = stage.start(Scripted("M1", answer), Cell(), journal)
        await asyncio.sleep(1.0)
        first.kill()
        stage.start(second := Scripted("M1"), Cell(), journal)
        await asyncio.sleep(1.0)
        started = second.events[0][1]
        assert isinstance(started, Started)
        assert started.memory == {WHOLE: AtvMemory(speed_frac=0.2), "O-2": EndedOrder()}

    play(story)


def test_an_agent_without_a_body_cannot_instruct_one() -> None:
    async def story(stage: Stage) -> None:
        stage.start(Scripted("S", lambda *_: [Instruct(StartCycle("a"))]))
        with pytest.raises(ProtocolViolation, match=r"S has no body and wants StartCycle"):
            await stage.tasks["S"]

    play(story)
