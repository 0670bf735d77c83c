"""How a worker ends: asked to leave, killed or by a bug, and what is still done then."""

from __future__ import annotations

import asyncio

import pytest
from agent_stage import Cell, FullStage, Listener, Scripted, Stage, play, say, wakes

from dray.body import CycleDone, Instruction, StartCycle
from dray.errors import ProtocolViolation
from dray.messages.fact import OrderFulfilled
from dray.protocol.runtime.events import (
    NEVER_S,
    Effect,
    Event,
    Instruct,
    Leave,
    Leaving,
    Publish,
    Received,
    Record,
    Reported,
    Send,
    Started,
    Woke,
)
from dray.worker.worker import Worker
from dray_sim.clock.loop import clock, run
from dray_sim.factory.journal import HeldJournal


def is_there(stage: Stage, name: str) -> bool:
    missed = stage.network.missed
    stage.network.join("probe", lambda *_: None).send(name, say("probe"))
    return stage.network.missed == missed


@pytest.mark.parametrize("way", ["stop", "cancel"])
def test_a_worker_that_ends_leaves_the_bus_and_its_body(way: str) -> None:
    async def story(stage: Stage) -> None:
        agent, cell = Scripted("M1", wake_at_s=10.0), Cell()
        worker = stage.start(agent, cell)
        await asyncio.sleep(1.0)
        assert is_there(stage, "M1")
        if way == "stop":
            worker.stop()
            worker.stop()
            await stage.tasks["M1"]
        else:
            stage.tasks["M1"].cancel()
            with pytest.raises(asyncio.CancelledError):
                await stage.tasks["M1"]
        assert not is_there(stage, "M1")
        events = len(agent.events)
        cell.report(CycleDone("late", 1))
        await asyncio.sleep(20.0)
        assert len(agent.events) == events

    play(story)


def test_an_agent_that_is_asked_to_leave_ends_when_it_says_so() -> None:
    def answer(event: Event, _: float) -> list[Effect]:
        if isinstance(event, Leaving):
            agent.wake_at_s = 5.0
        if isinstance(event, Woke):
            agent.wake_at_s = NEVER_S
            return [Publish("p/last", say("word")), Leave()]
        return []

    agent = Scripted("A1", answer)

    async def story(stage: Stage) -> None:
        listener = Listener(stage, "p/last")
        worker = stage.start(agent)
        await asyncio.sleep(1.0)
        worker.leave()
        await asyncio.sleep(1.0)
        assert is_there(stage, "A1")
        assert not worker.ended
        await stage.tasks["A1"]
        assert clock().now_s() == 5.0
        assert worker.ended
        assert not is_there(stage, "A1")
        await asyncio.sleep(1.0)
        assert listener.others == [say("word")]

    play(story)


def test_an_agent_that_is_asked_to_leave_before_its_first_turn_is_born_first() -> None:
    async def story(stage: Stage) -> None:
        agent = Scripted("A1", lambda event, _: [Leave()] if isinstance(event, Leaving) else [])
        stage.start(agent).leave()
        await stage.tasks["A1"]
        assert [type(event) for _, event in agent.events] == [Started, Leaving]

    play(story)


def test_a_killed_agent_does_not_even_finish_what_it_had_begun() -> None:
    workers: list[Worker] = []

    class Deadly(Cell):
        def instruct(self, instruction: Instruction) -> None:
            super().instruct(instruction)
            workers[0].kill()

    def answer(event: Event, _: float) -> list[Effect]:
        agent.wake_at_s = 1.0
        return [
            Send("H", say("before")),
            Instruct(StartCycle("a")),
            Instruct(StartCycle("b")),
            Send("H", say("after")),
            Record(OrderFulfilled("written, and never told")),
        ]

    agent = Scripted("M1", answer)

    async def story(stage: Stage) -> None:
        stranger, journal, cell = Listener(stage, "**"), HeldJournal(incarnation=3), Deadly()
        workers.append(stage.start(agent, cell, journal))
        await asyncio.sleep(5.0)
        workers[0].kill()
        assert workers[0].ended
        assert stage.tasks["M1"].done()
        assert stranger.others == [say("before")]
        assert stranger.events == []
        # Whoever asks the next life will hear it.
        assert len(journal.events(3, 1, 9)) == 1
        assert cell.instructions == [StartCycle("a")]
        assert len(agent.events) == 1

    play(story)


def test_the_next_life_may_begin_in_the_instant_in_which_one_is_killed() -> None:
    def sleep_on(event: Event, _: float) -> list[Effect]:
        if isinstance(event, Woke):
            second.wake_at_s = NEVER_S
        return []

    second = Scripted("M1", sleep_on, wake_at_s=3.0)

    async def story(stage: Stage) -> None:
        first, cell = Scripted("M1", wake_at_s=2.0), Cell()
        stranger = Listener(stage)
        worker = stage.start(first, cell)
        await asyncio.sleep(1.0)
        stranger.session.send("M1", say("under way to the first life"))
        worker.kill()
        stage.start(second, cell)
        await asyncio.sleep(1.0)
        stranger.session.send("M1", say("to the second life"))
        cell.report(CycleDone("a", 1))
        await asyncio.sleep(5.0)
        assert len(first.events) == 1
        assert second.heard() == ["to the second life"]
        assert Reported(CycleDone("a", 1)) in [event for _, event in second.events]
        assert wakes(second) == [3.0]

    play(story)


def test_an_agent_that_is_killed_before_its_first_turn_never_lives() -> None:
    async def story(stage: Stage) -> None:
        agent = Scripted("A1")
        stage.start(agent).kill()
        await stage.tasks["A1"]
        assert agent.events == []
        assert not is_there(stage, "A1")

    play(story)


def test_a_worker_stopped_in_the_middle_of_its_inbox_handles_no_more() -> None:
    def answer(event: Event, _: float) -> list[Effect]:
        if isinstance(event, Received):
            workers[0].stop()
        return []

    agent = Scripted("A1", answer)
    workers: list[Worker] = []

    async def main() -> None:
        stage = FullStage()
        workers.append(stage.start(agent))
        await asyncio.sleep(0.01)
        await stage.flood(workers[0], say(1), say(2))
        await stage.tasks["A1"]

    run(main())
    assert agent.heard() == ["1"]


def test_an_agent_with_a_bug_ends_and_says_so_and_others_go_on() -> None:
    def answer(event: Event, _: float) -> list[Effect]:
        if isinstance(event, Received):
            raise ProtocolViolation("a state that cannot be")
        return []

    async def story(stage: Stage) -> None:
        other = Scripted("A2")
        stage.start(Scripted("A1", answer))
        stage.start(other)
        stranger = stage.network.join("S", lambda *_: None)
        await asyncio.sleep(0)
        stranger.send("A1", say(1))
        with pytest.raises(ProtocolViolation, match="cannot be"):
            await stage.tasks["A1"]
        assert not is_there(stage, "A1")
        stranger.send("A2", say(2))
        await asyncio.sleep(1.0)
        assert other.heard() == ["2"]

    play(story)


def test_a_flood_on_one_agent_does_not_keep_the_others_from_their_turn() -> None:
    turns: list[str] = []

    def endless(event: Event, _: float) -> list[Effect]:
        turns.append("flooded")
        # Its body answers each instruction at once, so its inbox is never empty.
        return [Instruct(StartCycle("a"))] if len(turns) < 50 else []

    def other(event: Event, _: float) -> list[Effect]:
        turns.append("other")
        return []

    async def story(stage: Stage) -> None:
        stage.start(Scripted("M1", endless), Cell())
        stage.start(Scripted("A1", other))
        await asyncio.sleep(0.01)
        assert turns.index("other") < 5

    play(story)
