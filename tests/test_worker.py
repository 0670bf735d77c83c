"""The worker: what comes in reaches the agent in order, what the agent wants is done in order."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine
from random import Random
from typing import Any

import pytest
from msgspec.structs import replace

from dray import messages
from dray import worker as worker_module
from dray.body import (
    CycleDone,
    Instruction,
    Report,
    StartCycle,
    WorkcellState,
)
from dray.errors import ProtocolViolation
from dray.memory import WHOLE, AtvMemory, EndedOrder
from dray.messages import AtvHeartbeat, AtvStatus, EventsAsked, EventsKept, OrderTaken, Pose
from dray.messages.fact import EVENTS_PER_ANSWER, OrderFulfilled
from dray.messages.keys import Keys
from dray.protocol.runtime.events import (
    NEVER_S,
    Commit,
    Effect,
    Event,
    Heard,
    Instruct,
    Leave,
    Leaving,
    Publish,
    Record,
    Reported,
    Send,
    Started,
    Subscribe,
    Unsubscribe,
    Woke,
)
from dray.worker import Worker
from dray_sim.clock.loop import clock, run
from dray_sim.factory.journal import HeldJournal
from dray_sim.network.sim_network import SimNetwork

KEYS = Keys("p")

HEARTBEAT = AtvHeartbeat(
    atv="A1",
    incarnation=1,
    seq=1,
    at_s=0.0,
    status=AtvStatus.IDLE,
    pose=Pose(0.0, 0.0, 0.0),
    node="n1",
    speed_mps=0.0,
    battery_frac=1.0,
)

Answer = Callable[[Event, float], list[Effect]]


class Scripted:
    """An agent that notes its events and answers as the test says."""

    incarnation = 3

    def __init__(self, name: str, answer: Answer | None = None, wake_at_s: float = NEVER_S) -> None:
        self.id = name
        self.wake_at_s = wake_at_s
        self.events: list[tuple[float, Event]] = []
        self._answer = answer

    def handle(self, event: Event, now_s: float) -> list[Effect]:
        self.events.append((now_s, event))
        return self._answer(event, now_s) if self._answer else []

    def heard(self) -> list[str]:
        return [
            event.message.order
            for _, event in self.events
            if isinstance(event, Heard) and isinstance(event.message, OrderTaken)
        ]


class Cell:
    """A body that notes its instructions and answers each with a report, at once."""

    def __init__(self) -> None:
        self.instructions: list[Instruction] = []
        self.report: Callable[[Report], None] = lambda _: None
        self.made = 0

    def instruct(self, instruction: Instruction) -> None:
        self.instructions.append(instruction)
        self.made += 1
        self.report(CycleDone(product=str(self.made), seq=self.made))

    def sense(self) -> WorkcellState:
        return WorkcellState(stock={"made": self.made}, seq=self.made, cycling="", broken="")

    def attach(self, report: Callable[[Report], None]) -> None:
        self.report = report


class Stage:
    """One network; agents come on it as workers, and strangers without."""

    def __init__(self) -> None:
        self.network = SimNetwork(clock(), Random(1))
        self.tasks: dict[str, asyncio.Task[None]] = {}

    def start(self, agent: Scripted, body: Cell | None = None, journal: HeldJournal | None = None) -> Worker:
        worker = Worker(
            agent, bus=self.network, clock=clock(), keys=KEYS, body=body, journal=journal or HeldJournal()
        )
        self.tasks[agent.id] = asyncio.create_task(worker.run())
        return worker


def play(story: Callable[[Stage], Coroutine[Any, Any, None]]) -> None:
    async def main() -> None:
        await story(Stage())

    run(main())


def say(order: int | str) -> OrderTaken:
    return OrderTaken(order=str(order))


# --- what comes in ---------------------------------------------------------------------------------


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
        assert event == Heard("S", say(1))
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


# --- the timer -------------------------------------------------------------------------------------


def wakes(agent: Scripted) -> list[float]:
    return [at_s for at_s, event in agent.events if isinstance(event, Woke)]


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
        agent.wake_at_s = 1.0 if isinstance(event, Heard) else NEVER_S
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
            5.0 if isinstance(event, Heard) else now_s + 100.0 if isinstance(event, Woke) else 1.0
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
        if isinstance(event, Heard):
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
        agent.wake_at_s = now_s + 0.001 if isinstance(event, Heard) else 1000.0
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
        agent.wake_at_s = now_s - 1.0 if isinstance(event, Heard) else NEVER_S
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


# --- what goes out ---------------------------------------------------------------------------------


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
    return [Record(OrderFulfilled("o1")), Record(OrderFulfilled("o2"))] if isinstance(event, Heard) else []


class Listener:
    """A stranger that keeps the events and the rest of what it hears."""

    def __init__(self, stage: Stage, *keys: str, name: str = "H") -> None:
        self.events: list[messages.Event] = []
        self.others: list[messages.Message] = []
        self.session = stage.network.join(name, self._on_message)
        for key in keys:
            self.session.subscribe(key)

    def _on_message(self, _sender: str, message: messages.Message) -> None:
        if isinstance(message, messages.Event):
            self.events.append(message)
        else:
            self.others.append(message)


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


# --- what is told again ----------------------------------------------------------------------------


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
        assert historian.others == [EventsKept(incarnation=3, first=1, last=10, life=3)]
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
        assert historian.others == [EventsKept(incarnation=3, first=1, last=EVENTS_PER_ANSWER + 5, life=3)]

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
            EventsKept(incarnation=3, first=7, last=10, life=3),
            EventsKept(incarnation=2, first=1, last=0, life=3),
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
        assert historian.others == [EventsKept(incarnation=2, first=1, last=1, life=3)]

    play(story)


# --- what is remembered ----------------------------------------------------------------------------


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


# --- a flood ---------------------------------------------------------------------------------------


class FullStage(Stage):
    """A stage on which agents are flooded."""

    async def flood(self, worker: Worker, *flood: messages.Message | tuple[str, messages.Message]) -> None:
        # Straight into the inbox, as a bus does that delivers more than the worker gets turns for.
        for each in flood:
            sender, message = each if isinstance(each, tuple) else ("S", each)
            worker._on_message(sender, message)
        await asyncio.sleep(0.01)


@pytest.fixture
def small_inbox(monkeypatch: pytest.MonkeyPatch) -> None:
    """Room for 8, and for 6 of one sender; crowded from 2 on."""
    monkeypatch.setattr(worker_module, "INBOX", 8)
    monkeypatch.setattr(worker_module, "CROWDED", 2)
    monkeypatch.setattr(worker_module, "SENDER_ROOM", 6)


def flooded(*flood: messages.Message | tuple[str, messages.Message]) -> tuple[Worker, Scripted]:
    agent = Scripted("A1")
    workers: list[Worker] = []

    async def main() -> None:
        stage = FullStage()
        workers.append(stage.start(agent))
        await asyncio.sleep(0.01)
        await stage.flood(workers[0], *flood)

    run(main())
    return workers[0], agent


@pytest.mark.usefixtures("small_inbox")
def test_in_a_crowded_inbox_only_the_newest_heartbeat_of_a_sender_waits() -> None:
    beats = [replace(HEARTBEAT, seq=seq) for seq in (1, 2, 3, 5, 4)]
    worker, agent = flooded(*beats, say(1), say(2))
    heard = [event.message for _, event in agent.events if isinstance(event, Heard)]
    assert heard == [beats[0], beats[1], beats[3], say(1), say(2)]
    assert (worker.dropped_heartbeats, worker.dropped_messages) == (2, 0)


@pytest.mark.usefixtures("small_inbox")
def test_one_sender_fills_no_inbox_and_pushes_out_nothing_of_others() -> None:
    flood = [("LIAR", say(number)) for number in range(100)]
    worker, agent = flooded(("A", say("first")), *flood, ("B", say("last")), ("C", HEARTBEAT))
    assert agent.heard() == ["first", *(str(number) for number in range(6)), "last"]
    assert worker.dropped_messages == 94


@pytest.mark.usefixtures("small_inbox")
def test_a_full_inbox_drops_the_oldest_message_of_whoever_has_most_there() -> None:
    worker, agent = flooded(
        ("A", say("a")), *[("S", say(number)) for number in range(7)], ("B", say("b1")), ("B", say("b2"))
    )
    assert agent.heard() == ["a", *(str(number) for number in range(1, 6)), "b1", "b2"]
    assert (worker.dropped_heartbeats, worker.dropped_messages) == (0, 2)


@pytest.mark.usefixtures("small_inbox")
def test_a_full_inbox_never_drops_what_the_body_reports() -> None:
    agent, cell = Scripted("A1"), Cell()

    async def main() -> None:
        stage = FullStage()
        worker = stage.start(agent, cell)
        await asyncio.sleep(0.01)
        for number in range(12):
            cell.report(CycleDone(str(number), number))
        await stage.flood(worker, say("no room"))
        assert worker.dropped_messages == 1

    run(main())
    assert [event for _, event in agent.events[1:]] == [
        Reported(CycleDone(str(number), number)) for number in range(12)
    ]


# --- the end ---------------------------------------------------------------------------------------


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
        if isinstance(event, Heard):
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
        if isinstance(event, Heard):
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
