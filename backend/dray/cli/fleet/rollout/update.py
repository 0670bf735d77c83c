"""The update of a running fleet: agents are replaced one at a time, each a canary, and all are rolled back when one fails.

    shuts down gracefully -> ends -> the new one starts -> is on the bus -> is a canary -> has passed -> the next agent
                                    |                    |               |
                                    +-- ends, is not there in time, reports another version, does badly
                                                         |
                                 it is rolled back at once; then all that were replaced before it, in order

All are rolled back, and not that one alone. The others have passed with the same software by a few tasks, but they have the same
fault.

A canary without work within the timeout is untried. It stays if another agent of its kind has passed; otherwise it is rolled back
alone, and the update stops there. Started again, an update continues there.
"""

from __future__ import annotations

import asyncio
import contextlib
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import msgspec

from dray.cli.fleet.folder import GATEWAY, HISTORIAN, UPDATE_LOCK, alone, read_settings
from dray.cli.fleet.process_registry import Member, ProcessRegistry, State, read_registry
from dray.cli.fleet.rollout.history import History
from dray.cli.fleet.rollout.listener import Listener
from dray.cli.fleet.rollout.order_statistics import OrderCount, OrderStatistics
from dray.cli.fleet.rollout.replacement import Scene, Terms
from dray.cli.fleet.rollout.report import Cost, Flow, Report, Step, Verdict
from dray.cli.fleet.software import Software
from dray.cli.runtime.output import one_of
from dray.cli.runtime.signals import stopped_by_signals
from dray.errors import SettingsError, UnavailableError
from dray.messages.kinds import Kind

ORDER: Sequence[str] = (Kind.ATV, Kind.STATION, Kind.MACHINE, Kind.GATE, Kind.STRATEGIST, HISTORIAN, GATEWAY)
"""The order of kinds. Vehicles come first, because others can do their work. The floor stands for hardware, without our software."""

BASELINE_S = 3600.0
"""The time before the update for comparison (plant clock)."""

WHOLE_S = 90.0
"""Longest wait for the complete history (real seconds): the historian asks for a missed last fact within a minute."""

ASK_AGAIN_S = 0.5
"""Real seconds between two checks whether it is complete."""

Tell = Callable[[str], None]
"""Tells a person the progress."""


@dataclass(frozen=True, slots=True)
class Plan:
    """An update's parameters.

    Attributes:
        folder: the fleet's folder.
        target: the software for all.
        only: these processes; empty for all.
        canary_tasks: tasks that each agent must do well.
        patience_s: maximum time for these tasks (plant clock).
    """

    folder: Path
    target: Software
    only: Sequence[str]
    canary_tasks: int
    patience_s: float


async def update_fleet(plan: Plan, tell: Tell) -> Report:
    """Update a fleet; a signal stops it where it is.

    Raises:
        SettingsError: a name is unknown, or the software does not speak with the others.
        UnavailableError: there is no fleet, or its `dray fleet up` does not answer.
    """
    registry = read_registry(plan.folder)
    with alone(plan.folder, UPDATE_LOCK, "`dray fleet update`", "wait for its end"):
        settings = read_settings(plan.folder)
        members = replaceable(registry, plan)
        listener = Listener(registry, plan.folder)
        try:
            async with OrderStatistics.open(settings.database_url) as statistics:
                scene = Scene(plan.folder, settings, listener)
                update = Update(plan, scene, listener, statistics, tell)
                return await update.run(members, proven_kinds(registry, plan.target))
        finally:
            listener.close()


def replaceable(registry: ProcessRegistry, plan: Plan) -> list[Member]:
    """The processes to replace, in order: those without the target software, or with it only as a canary.

    Raises:
        SettingsError: a name is unknown, or the software does not speak with the others.
    """
    there = {member.name: member for member in registry.members if member.kind in ORDER}
    chosen = [one_of(there, name, "--only") for name in dict.fromkeys(plan.only)] or list(there.values())
    for member in there.values():
        if member.software.wire != plan.target.wire:
            raise SettingsError(
                "--python",
                f"{plan.target.version} speaks wire version {plan.target.wire} and {member.name} "
                f"{member.software.wire}: they would not understand each other; end the fleet, and start it anew",
            )
    wanted = [each for each in chosen if each.software != plan.target or each.state is State.CANARY]
    return sorted(wanted, key=lambda member: ORDER.index(member.kind))


def proven_kinds(registry: ProcessRegistry, software: Software) -> set[str]:
    """Kinds of agents of which one has passed as a canary with this software."""
    return {
        member.kind
        for member in registry.members
        if member.software == software and member.state is State.AT_WORK
    }


class Update:
    """One update in progress.

    Args:
        plan: its parameters.
        scene: the fleet.
        listener: a listener on the fleet's bus.
        statistics: the fleet's statistics.
        tell: tells the progress.
    """

    def __init__(
        self, plan: Plan, scene: Scene, listener: Listener, statistics: OrderStatistics, tell: Tell
    ) -> None:
        self._plan, self._scene, self._listener = plan, scene, listener
        self._statistics, self._tell = statistics, tell
        self._steps: list[Step] = []
        self._done = False
        self._end = (
            "interrupted: every process goes on with the version that it runs, see `dray fleet status`"
        )

    async def run(self, members: Sequence[Member], proven: set[str]) -> Report:
        """Replace processes, one after the other, and report the cost.

        Args:
            members: the processes, in order.
            proven: kinds of which one agent has passed already; grows.
        """
        began_s, before = self._scene.now_s(), await self._statistics.orders()
        working = asyncio.create_task(self._work(members, proven))
        with stopped_by_signals(lambda: _cancel(working)), contextlib.suppress(asyncio.CancelledError):
            await working
        ended_s = self._scene.now_s()
        try:
            cost = await self._cost(before, began_s, ended_s) if self._steps else None
        except UnavailableError as error:
            self._tell(str(error))
            cost = None
        return Report(
            version=self._plan.target.version,
            done=self._done,
            end=self._end,
            speed=self._scene.speed,
            took_s=(ended_s - began_s) / self._scene.speed,
            steps=tuple(self._steps),
            cost=cost,
        )

    async def _work(self, members: Sequence[Member], proven: set[str]) -> None:
        for place, member in enumerate(members):
            step = await self._try(member)
            if step.verdict is Verdict.FAILED:
                self._end = f"{member.name} has failed with {step.version}: {step.why}"
                away = await self._roll_back(member, members[:place])
                self._end += f"; {', '.join(away)} did not come back" if away else "; all are back"
                return
            if step.verdict is Verdict.UNTRIED and member.kind not in proven:
                await self._go_back(member)
                self._end = (
                    f"stopped: {member.name} has done {step.tasks} of {self._plan.canary_tasks} tasks, and no other "
                    f"{member.kind} has passed; start it again when there is more to do, or with more --patience"
                )
                return
            if step.verdict is Verdict.PASSED:
                proven.add(member.kind)
            await self._scene.settle(member)
        self._done = True
        self._end = f"{len(members)} processes updated" if members else "every process runs it already"

    async def _try(self, member: Member) -> Step:
        plan = self._plan
        self._tell(f"{member.name}: leaves, and comes back with {plan.target.version}")
        return await self._replace(member, Terms(plan.target, plan.canary_tasks, plan.patience_s))

    async def _roll_back(self, failed: Member, replaced: Sequence[Member]) -> list[str]:
        """Restore the earlier software: of the failed process at once, of the others in order.

        Returns:
            The processes that are not back with it.
        """
        steps = [await self._go_back(failed, at_once=True)]
        steps += [await self._go_back(member) for member in reversed(replaced)]
        return [step.agent for step in steps if step.verdict is Verdict.FAILED]

    async def _go_back(self, member: Member, *, at_once: bool = False) -> Step:
        software = member.proven
        self._tell(f"{member.name}: goes back to {software.version}")
        return await self._replace(member, Terms(software, at_once=at_once), passed=Verdict.BACK)

    async def _replace(self, member: Member, terms: Terms, passed: Verdict = Verdict.PASSED) -> Step:
        step = await self._scene.replace(member, terms)
        if step.verdict is Verdict.PASSED:
            step = msgspec.structs.replace(step, verdict=passed)
        self._steps.append(step)
        self._tell(f"{member.name}: {step.verdict}{f': {step.why}' if step.why else ''}")
        return step

    async def _cost(self, orders: OrderCount, began_s: float, ended_s: float) -> Cost:
        """Measure the factory's performance, as soon as its history is complete.

        Args:
            orders: the count before the update.
            began_s: the update's beginning (plant clock).
            ended_s: the update's end (plant clock).
        """
        # Take these at this moment, because the factory goes on.
        numbers, machines = dict(self._listener.numbers), dict(self._listener.machines)
        missing = await self._until_written(numbers)
        since_s = max(self._scene.first_s, began_s - BASELINE_S)
        history = await self._statistics.history(since_s, ended_s)
        self._steps = [
            msgspec.structs.replace(step, passed_on=history.passed_on(step.agent, step.began_s, step.ended_s))
            for step in self._steps
        ]
        return Cost(
            before=_flow(history, since_s, began_s),
            during=_flow(history, began_s, ended_s),
            orders=(await self._statistics.orders()).since(orders),
            lost=tuple(sorted(history.lost(machines))),
            twice=tuple(sorted(history.twice)),
            missing=missing,
        )

    async def _until_written(self, numbers: Mapping[str, tuple[int, int]]) -> int:
        """Wait until the history contains all facts up to these numbers; returns the number still missing."""
        latest_s = time.monotonic() + WHOLE_S
        while True:
            missing = await self._statistics.missing(numbers)
            if not missing or time.monotonic() > latest_s:
                return missing
            await asyncio.sleep(ASK_AGAIN_S)


def _flow(history: History, from_s: float, to_s: float) -> Flow:
    return Flow(history.per_minute(from_s, to_s), history.worst_per_minute(from_s, to_s))


def _cancel(task: asyncio.Task[None]) -> None:
    task.cancel()
