"""A worker wakes its agent when the agent wants to be woken."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from agent_stage import KEYS, Cell, Scripted, Stage, play, say, wakes

from dray.body import WorkcellState
from dray.protocol.runtime.events import (
    NEVER_S,
    Effect,
    Event,
    Received,
    Woke,
)
from dray.worker.worker import Worker
from dray_sim.clock.loop import clock
from dray_sim.factory.journal import HeldJournal


def test_an_agent_is_woken_when_it_wants_and_senses_its_body_then() -> None:
    def answer(event: Event, now_s: float) -> list[Effect]:
        if isinstance(event, Woke):
            agent.wake_at_s = now_s + 2.0
        return []

    agent = Scripted("M1", answer, wake_at_s=1.0)

    async def story(stage: Stage) -> None:
        cell = Cell()
        stage.start(agent, cell)
        await asyncio.sleep(3.5)
        cell.made = 7
        await asyncio.sleep(2.0)
        assert wakes(agent) == [1.0, 3.0, 5.0]
        assert agent.events[-1][1] == Woke(WorkcellState(stock={"made": 7}, seq=7, cycling="", broken=""))

    play(story)


class LateClock:
    """The clock of a process that is held up: between 2 s and 7 s nothing is called."""

    def now_s(self) -> float:
        return clock().now_s()

    def call_at(self, when_s: float, callback: Callable[[], None]) -> None:
        clock().call_at(7.0 if 2.0 < when_s < 7.0 else when_s, callback)


def test_an_agent_is_told_how_long_its_own_process_was_held_up() -> None:
    def answer(event: Event, now_s: float) -> list[Effect]:
        if isinstance(event, Woke):
            agent.wake_at_s = now_s + 1.0
        return []

    agent = Scripted("M1", answer, wake_at_s=1.0)

    async def story(stage: Stage) -> None:
        worker = Worker(
            agent, bus=stage.network, clock=LateClock(), keys=KEYS, body=None, journal=HeldJournal()
        )
        living = asyncio.create_task(worker.run())
        await asyncio.sleep(9.5)
        living.cancel()
        late_s = [(at_s, event.late_s) for at_s, event in agent.events if isinstance(event, Woke)]
        assert late_s == [(1.0, 0.0), (2.0, 0.0), (7.0, 4.0), (8.0, 0.0), (9.0, 0.0)]

    play(story)


def test_a_wish_for_a_time_that_is_past_is_nobodys_delay() -> None:
    def answer(event: Event, now_s: float) -> list[Effect]:
        agent.wake_at_s = 1.0 if isinstance(event, Received) else NEVER_S
        return []

    agent = Scripted("A1", answer)

    async def story(stage: Stage) -> None:
        stage.start(agent)
        await asyncio.sleep(5.0)
        stage.network.join("S", lambda *_: None).send("A1", say(1))
        await asyncio.sleep(5.0)
        [woke] = [event for _, event in agent.events if isinstance(event, Woke)]
        assert woke.late_s == 0.0

    play(story)


def test_an_agent_that_wants_to_sleep_longer_is_not_woken_before() -> None:
    def answer(event: Event, now_s: float) -> list[Effect]:
        agent.wake_at_s = (
            5.0 if isinstance(event, Received) else now_s + 100.0 if isinstance(event, Woke) else 1.0
        )
        return []

    agent = Scripted("A1", answer)

    async def story(stage: Stage) -> None:
        stage.start(agent)
        await asyncio.sleep(0)
        stage.network.join("S", lambda *_: None).send("A1", say(1))
        await asyncio.sleep(50.0)
        assert wakes(agent) == [5.0]

    play(story)


def test_an_agent_that_wants_to_be_woken_earlier_is() -> None:
    def answer(event: Event, now_s: float) -> list[Effect]:
        if isinstance(event, Received):
            agent.wake_at_s = 2.0
        elif isinstance(event, Woke):
            agent.wake_at_s = 10.0 if now_s < 10.0 else NEVER_S
        return []

    agent = Scripted("A1", answer, wake_at_s=10.0)

    async def story(stage: Stage) -> None:
        stage.start(agent)
        await asyncio.sleep(0)
        stage.network.join("S", lambda *_: None).send("A1", say(1))
        await asyncio.sleep(50.0)
        assert wakes(agent) == [2.0, 10.0]

    play(story)


def test_changing_its_mind_does_not_pile_up_calls_of_the_clock() -> None:
    def answer(event: Event, now_s: float) -> list[Effect]:
        # Every message makes it hurry for a moment; afterwards it waits for its far goal again.
        agent.wake_at_s = now_s + 0.001 if isinstance(event, Received) else 1000.0
        return []

    agent = Scripted("A1", answer, wake_at_s=1000.0)

    async def story(stage: Stage) -> None:
        stage.start(agent)
        stranger = stage.network.join("S", lambda *_: None)
        await asyncio.sleep(0)
        for number in range(500):
            stranger.send("A1", say(number))
            await asyncio.sleep(0.1)
        await asyncio.sleep(1.0)
        assert len(agent.heard()) == 500
        assert len(clock().heap) <= 2

    play(story)


def test_a_wake_up_time_that_is_past_means_at_once() -> None:
    def answer(event: Event, now_s: float) -> list[Effect]:
        agent.wake_at_s = now_s - 1.0 if isinstance(event, Received) else NEVER_S
        return []

    agent = Scripted("A1", answer)

    async def story(stage: Stage) -> None:
        stage.start(agent)
        await asyncio.sleep(5.0)
        stage.network.join("S", lambda *_: None).send("A1", say(1))
        await asyncio.sleep(1.0)
        heard_s = agent.events[-2][0]
        assert wakes(agent) == [heard_s]

    play(story)
