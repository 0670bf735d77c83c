"""Case 6: new software, agent by agent, while production runs."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Sequence
from dataclasses import dataclass
from functools import partial
from statistics import median

from dray.messages import Phase, Reason
from dray.messages.fact import CarrierChanged, GoalLost, PrimarySuspected, TaskClosed
from dray.messages.keys import STRATEGIST
from dray.plant import default_plant
from dray.scenario_steps import ScenarioStep
from dray_sim.run.evidence import Check, Table
from dray_sim.run.part import Part
from dray_sim.run.scenario import Findings, Scenario
from dray_sim.run.stage import Shift, Stage, play
from dray_sim.scenarios.tally import SETTLE_S, Tally, all_delivered, tally

NEW = "next"
"""The other version. It sends the same messages, like every version of one wire version."""

WARM_UP_S = 1800.0

SPAN_S = 3 * 3600.0
"""Time from the first leaving on: enough for all agents with any work."""

AWAY_S = 5.0
"""A process has ended, the new one starts."""

FIRST_PROBATION, PROBATION = 2, 1
"""Transports that the first one has to do well, and each of the others."""

FIRST_PATIENCE_S = 3600.0
"""Longest probation of the first agent: after it no other agent is updated."""

KINDS = ("vehicles", "machines", "strategist")

PHASES = (Phase.APPROACHING, Phase.CARRYING)
"""Phases in which vehicles are asked to leave, in turn: one hands its task over, the next finishes it."""

PATIENCE_S = 300.0
"""Longest probation of each of the others: one without work must not hold up all others."""

SHARE = 0.9
"""Least share of the transports that must be done; the two runs differ by chance about as much."""

ON_TIME_COST = 0.05
"""Largest fraction of the orders that the update may delay."""

SHIFT = Shift(
    name="case-6",
    duration_s=WARM_UP_S + SPAN_S,
    load=0.9,
    keep=(CarrierChanged, GoalLost, PrimarySuspected, TaskClosed),
)


@dataclass(frozen=True, slots=True)
class Replaced:
    """One agent, with the new version.

    Attributes:
        kind: of the agent, one of `KINDS`.
        left_s: from the request to leave until it had left.
        tried_s: from its start until its probation was passed; None when it had no work in time.
    """

    kind: str
    left_s: float
    tried_s: float | None


@dataclass(frozen=True, slots=True)
class Span:
    """Observations during the update, in a run with it or without.

    Attributes:
        replaced: all agents that were updated, in their order.
        took_s: how long both versions were at work; the counts are of this time.
        old: agents that report the old version at the end.
        changed: reasons for changes of carriers.
        suspected: number of suspicions.
        lost: goals that a machine lost.
        withdrawn: tasks that ended otherwise than by their delivery.
    """

    transports: int
    pieces: int
    replaced: tuple[Replaced, ...]
    took_s: float
    agents: int
    old: tuple[str, ...]
    changed: tuple[str, ...]
    suspected: int
    lost: int
    withdrawn: int
    tally: Tally

    def row(self, name: str) -> tuple[str, ...]:
        """A row of the table."""
        on_time = f"{self.tally.on_time_frac:.1%}"
        counts = (self.transports, self.pieces, len(self.changed), self.suspected, self.lost)
        return (name, *map(str, counts), on_time)


async def update(stage: Stage) -> Span:
    """Update one vehicle, try it, then update everybody else, one after another."""
    return await _span(stage, _update)


async def let_be(stage: Stage, took_s: float) -> Span:
    """Let the same time pass without an update."""

    async def pass_time(_stage: Stage) -> tuple[Replaced, ...]:
        await asyncio.sleep(took_s)
        return ()

    return await _span(stage, pass_time)


async def _span(stage: Stage, act: Callable[[Stage], Awaitable[tuple[Replaced, ...]]]) -> Span:
    seen, witness = stage.observer, stage.witness
    await stage.until_s(WARM_UP_S)
    transports, pieces = len(seen.took_s), sum(seen.delivered.values())
    replaced = await act(stage)
    took_s = stage.now_s() - WARM_UP_S
    transports, pieces = len(seen.took_s) - transports, sum(seen.delivered.values()) - pieces
    await stage.until_s(stage.shift.duration_s)
    settled_s = await stage.settle(SETTLE_S)
    if not stage.undelivered():
        stage.steps.tell(ScenarioStep.ALL_DELIVERED)
    versions = {atv: heard.software for atv, heard in witness.atvs.items()}
    versions.update((machine, heard.software) for machine, heard in witness.machines.items())
    closed = witness.all(TaskClosed, since_s=WARM_UP_S)
    return Span(
        transports=transports,
        pieces=pieces,
        replaced=replaced,
        took_s=took_s,
        agents=len(versions),
        old=tuple(agent for agent, software in versions.items() if software != NEW),
        changed=tuple(changed.said.reason for changed in witness.all(CarrierChanged, since_s=WARM_UP_S)),
        suspected=len(witness.all(PrimarySuspected, since_s=WARM_UP_S)),
        lost=len(witness.all(GoalLost, since_s=WARM_UP_S)),
        withdrawn=sum(ended.said.outcome != "delivered" for ended in closed),
        tally=tally(stage, settled_s),
    )


async def _update(stage: Stage) -> tuple[Replaced, ...]:
    """Update all agents, if the first one proves good."""
    vehicles, machines, strategist = KINDS
    old = list(stage.factory.vehicles)
    first = await _at_work(stage, old, PHASES[0])
    stage.steps.tell(ScenarioStep.FIRST_UPDATED, first)
    replaced = [await _replace(stage, vehicles, first, FIRST_PROBATION, FIRST_PATIENCE_S)]
    if replaced[0].tried_s is not None:
        stage.steps.tell(ScenarioStep.FIRST_PROVEN, first)
        while old:
            atv = await _at_work(stage, old, PHASES[len(old) % len(PHASES)])
            replaced.append(await _replace(stage, vehicles, atv, PROBATION, PATIENCE_S))
        stage.steps.tell(ScenarioStep.VEHICLES_UPDATED)
        replaced += [
            await _replace(stage, machines, machine, PROBATION, PATIENCE_S)
            for machine in stage.factory.workcells
        ]
        stage.steps.tell(ScenarioStep.MACHINES_UPDATED)
        # The strategist gets no transports for a probation.
        replaced.append(await _replace(stage, strategist, STRATEGIST, 0, 0.0))
        stage.steps.tell(ScenarioStep.ALL_UPDATED)
    return tuple(replaced)


async def _at_work(stage: Stage, old: list[str], phase: Phase) -> str:
    """Take out a vehicle in this phase, or the next one when none is in time."""
    for _ in range(int(PATIENCE_S)):
        for atv in old:
            task = stage.witness.atvs[atv].task
            if task is not None and task.phase is phase:
                old.remove(atv)
                return atv
        await asyncio.sleep(1.0)
    return old.pop(0)


async def _replace(stage: Stage, kind: str, agent: str, probation: int, patience_s: float) -> Replaced:
    asked_s = stage.now_s()
    await stage.factory.leave(agent)
    left_s = stage.now_s()
    await asyncio.sleep(AWAY_S)
    stage.factory.restart(agent, software=NEW, probation=probation)
    started_s = stage.now_s()
    passed = await _pass_probation(stage, agent, patience_s)
    return Replaced(kind, left_s - asked_s, stage.now_s() - started_s if passed else None)


async def _pass_probation(stage: Stage, agent: str, patience_s: float) -> bool:
    """Wait until an agent says that its probation is over; whether it came to that."""
    witness = stage.witness
    for _ in range(int(patience_s)):
        await asyncio.sleep(1.0)
        heard = witness.atvs.get(agent) or witness.machines[agent]
        if heard.software == NEW and heard.probation is None:
            return True
    return False


def _judge(result: Span) -> tuple[Check, ...]:
    """The checks that need no comparison with the run without an update."""
    first = result.replaced[0]
    return (
        Check(
            f"One vehicle is tried out alone, among others of the old version, and does {FIRST_PROBATION} transports",
            first.tried_s is not None,
            "not in time" if first.tried_s is None else f"in {first.tried_s / 60:.0f} minutes",
        ),
        Check(
            "In the end every agent runs the new version",
            not result.old,
            f"{result.agents - len(result.old)} of {result.agents} in {result.took_s / 60:.0f} minutes; one at a time, each "
            f"away for {AWAY_S:.0f} s",
        ),
        Check(
            "Nobody is missed: nobody is suspected, and carriers change in planned takeovers only",
            not result.suspected and set(result.changed) <= {Reason.GRACEFUL_SHUTDOWN},
            f"suspected: {result.suspected}; planned takeovers: {result.changed.count(Reason.GRACEFUL_SHUTDOWN)} of {len(result.changed)}",
        ),
        Check(
            "Nothing is lost: no machine loses a goal, and every task that ends is delivered",
            not result.lost and not result.withdrawn,
            f"goals: {result.lost}; tasks: {result.withdrawn}",
        ),
    )


PART = Part(
    "case-6",
    SHIFT,
    default_plant,
    update,
    (
        ScenarioStep.FIRST_UPDATED,
        ScenarioStep.FIRST_PROVEN,
        ScenarioStep.VEHICLES_UPDATED,
        ScenarioStep.MACHINES_UPDATED,
        ScenarioStep.ALL_UPDATED,
        ScenarioStep.ALL_DELIVERED,
    ),
    _judge,
)


def case_6(seed: int, part: Part[Span] = PART) -> Findings:
    """Play the same demand with the update and without, for as long as the part lasts, in its plant."""
    updated = part.play(seed)
    result = updated.result
    if result is None:
        return Findings(runs=(updated,), checks=())
    twin_run = play(part.shift, part.plant(), seed, partial(let_be, took_s=result.took_s))
    twin = twin_run.result
    if twin is None:
        return Findings(runs=(updated, twin_run), checks=())
    cost = twin.tally.on_time_frac - result.tally.on_time_frac
    return Findings(
        runs=(updated, twin_run),
        checks=(
            *part.checks(updated),
            Check(
                f"Production goes on: at least {SHARE:.0%} of the transports and pieces of the same time without an update",
                result.transports >= SHARE * twin.transports and result.pieces >= SHARE * twin.pieces,
                f"{result.transports} transports, without {twin.transports}; {result.pieces} pieces, without {twin.pieces}",
            ),
            all_delivered((updated, twin_run)),
            Check(
                f"It makes no more than {ON_TIME_COST:.0%} of the orders late",
                cost <= ON_TIME_COST,
                f"{result.tally.on_time_frac:.1%} on time, without {twin.tally.on_time_frac:.1%}",
            ),
        ),
        tables=(
            Table(
                f"The same {result.took_s / 60:.0f} minutes, with the update and without",
                ("", "transports", "pieces", "carriers changed", "suspected", "goals lost", "on time"),
                (result.row("update"), twin.row("no update")),
            ),
            Table(
                "How long agents took to leave, and for their probation",
                ("", "agents", "left in, median", "longest", "tried in, median", "without work in time"),
                tuple(_row(kind, result.replaced) for kind in KINDS),
            ),
        ),
    )


def _row(kind: str, replaced: Sequence[Replaced]) -> tuple[str, ...]:
    those = [each for each in replaced if each.kind == kind]
    left_s = [each.left_s for each in those]
    tried_s = [each.tried_s for each in those if each.tried_s is not None]
    return (
        kind,
        str(len(those)),
        f"{median(left_s):.1f} s" if left_s else "-",
        f"{max(left_s):.1f} s" if left_s else "-",
        f"{median(tried_s):.0f} s" if tried_s else "-",
        "-" if kind == KINDS[2] else str(len(those) - len(tried_s)),
    )


CASE_6 = Scenario(
    name="case-6",
    shows="Agents leave one by one and come back on probation with another software version, while production runs.",
    source="paper, 4.2 case 6",
    claim=(
        "Software is updated agent by agent: one is tried out first, then the others follow. Neither the factory nor an "
        "area of it has to stop."
    ),
    story=(
        f"The default plant at {SHIFT.load:.0%} load. A vehicle shuts down gracefully, comes back with another software version, "
        f"and drives with it alone until it has done {FIRST_PROBATION} short transports. Then the other vehicles, the machines "
        f"and the strategist follow: each leaves when the one before has done a transport on probation, or has had none to do "
        f"in {PATIENCE_S / 60:.0f} minutes. Every vehicle is asked to leave when it has a task: the first on its way to the "
        f"load, the next with the load on board, and so on. Beside it the same demand without an update."
    ),
    play=case_6,
    parts=(PART,),
)
