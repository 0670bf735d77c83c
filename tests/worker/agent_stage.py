"""An agent that does what is written in its part, on a stage with a bus, a body and a clock, for tests of the worker."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine
from random import Random
from typing import Any

from dray import messages
from dray.body import CycleDone, Instruction, Report, WorkcellState
from dray.messages import OrderTaken
from dray.messages.keys import Keys
from dray.protocol.runtime.events import (
    NEVER_S,
    Effect,
    Event,
    Received,
    Woke,
)
from dray.worker.worker import Worker
from dray_sim.clock.loop import clock, run
from dray_sim.factory.journal import HeldJournal
from dray_sim.network.sim_network import SimNetwork

KEYS = Keys("p")

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
            if isinstance(event, Received) and isinstance(event.message, OrderTaken)
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


def wakes(agent: Scripted) -> list[float]:
    return [at_s for at_s, event in agent.events if isinstance(event, Woke)]


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


class FullStage(Stage):
    """A stage on which agents are flooded."""

    async def flood(self, worker: Worker, *flood: messages.Message | tuple[str, messages.Message]) -> None:
        # Straight into the inbox, as a bus does that delivers more than the worker gets turns for.
        for each in flood:
            sender, message = each if isinstance(each, tuple) else ("S", each)
            worker.inbox.on_message(sender, message)
        await asyncio.sleep(0.01)


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
