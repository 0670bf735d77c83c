"""The result and cost of an update: as data, and as tables for people."""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum

import msgspec

from dray.cli.fleet.rollout.order_statistics import OrderCount
from dray.cli.runtime.output import table


class Verdict(StrEnum):
    """The result of one replacement."""

    PASSED = "passed"
    UNTRIED = "no work to be tried with"
    FAILED = "failed"
    BACK = "rolled back"


class Step(msgspec.Struct, frozen=True, kw_only=True):
    """One replacement of a process. Seconds are real ones unless noted.

    Attributes:
        began_s: the time of the shutdown request (plant clock).
        ended_s: the time of the verdict (plant clock).
        left_s: from the shutdown request to the end of the old process.
        killed: whether it had to be killed.
        away_s: from then on until the new one was on the bus.
        canary_s: from then on until the verdict.
        tasks: done well as a canary.
        passed_on: tasks taken over by others because of it.
        why: the reason of an unusual verdict.
    """

    agent: str
    kind: str
    version: str
    verdict: Verdict
    began_s: float
    ended_s: float
    left_s: float
    killed: bool
    away_s: float
    canary_s: float
    tasks: int = 0
    passed_on: int = 0
    why: str = ""


class Flow(msgspec.Struct, frozen=True):
    """Transports delivered per minute of the plant's clock.

    Attributes:
        mean: over all the time.
        worst: over the worst window in it (`dray.cli.fleet.rollout.history`).
    """

    mean: float
    worst: float


class Cost(msgspec.Struct, frozen=True, kw_only=True):
    """The factory's performance during the update.

    Attributes:
        before: over an hour before the update, or since the fleet's start.
        during: from the first shutdown to the last verdict.
        orders: during the update.
        lost: tasks that no agent mentions any more; must be empty.
        twice: tasks that were handed over twice; must be empty.
        missing: number of facts that the history lacks, and so the error of these figures.
    """

    before: Flow
    during: Flow
    orders: OrderCount
    lost: tuple[str, ...]
    twice: tuple[str, ...]
    missing: int


class Report(msgspec.Struct, frozen=True, kw_only=True):
    """The whole update.

    Attributes:
        version: the target version.
        done: whether every agent to be replaced runs it.
        end: how it ended, in words.
        speed: plant seconds per real second.
        took_s: real seconds.
        cost: None when the database was unavailable.
    """

    version: str
    done: bool
    end: str
    speed: float
    took_s: float
    steps: tuple[Step, ...]
    cost: Cost | None


def show(report: Report) -> None:
    """Print the report on stdout."""
    if report.steps:
        table(
            ("process", "version", "left in", "away", "as canary", "tasks", "passed on", "verdict"),
            [_row(step) for step in report.steps],
        )
        table(("", "before", "during"), _costs(report))


def _row(step: Step) -> Sequence[str]:
    return (
        step.agent,
        step.version,
        f"{step.left_s:.1f} s{', killed' if step.killed else ''}",
        f"{step.away_s:.1f} s",
        f"{step.canary_s:.0f} s",
        str(step.tasks),
        str(step.passed_on),
        step.verdict,
    )


def _costs(report: Report) -> Sequence[tuple[str, str, str]]:
    time = ("real time", "", f"{report.took_s:.0f} s")
    cost = report.cost
    if cost is None:
        return (time, ("what it has cost", "", "unknown: the database was away"))
    before, during = cost.before, cost.during
    return (
        time,
        ("transports per factory minute", f"{before.mean:.2f}", f"{during.mean:.2f}"),
        ("in the worst quarter of an hour", f"{before.worst:.2f}", f"{during.worst:.2f}"),
        ("orders delivered", "", str(cost.orders.delivered)),
        ("orders late", "", str(cost.orders.late)),
        ("tasks lost", "", _named(cost.lost)),
        ("tasks handed over twice", "", _named(cost.twice)),
        ("facts that the history lacks", "", str(cost.missing)),
    )


def _named(tasks: Sequence[str]) -> str:
    return f"{len(tasks)}: {', '.join(tasks)}" if tasks else "0"
