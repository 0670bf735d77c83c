"""The benefit of judging problems: the lost time for each kind, when bodies give words alone and when they tell the kind.

With right of way a vehicle that cannot drive is in the way of others, so people who cannot repair it on the spot
carry it away. Otherwise all figures would show the jam behind a dead drive before the only gate.
"""

from __future__ import annotations

import asyncio
from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from math import log

from dray.messages import NOTHING_KNOWN, AtvStatus, Phase, Problem, ProblemKind
from dray.messages.fact import TaskClosed, TookOver
from dray.plant import Plant, default_plant
from dray_sim.faults import VehicleBroken
from dray_sim.people.carriers import Carriers, Carrying
from dray_sim.people.floor_office import FloorOffice
from dray_sim.run.evidence import Check, Table
from dray_sim.run.scenario import Findings, Scenario
from dray_sim.run.stage import Played, Shift, Stage, play

SEEDS = 6

SHIFT = Shift(name="problems", duration_s=2 * 3600.0, load=0.6, keep=(TaskClosed, TookOver))

EVERY_S = 90.0
"""Between two problems, in the mean, where somebody is on the way: hardly two vehicles stand at a time. A vehicle
that stands before a dock holds up all others there. The cost of one problem shows only where there is no other."""

CARRIED_AFTER_S = 180.0
"""Time after which a person carries a vehicle away that is not repaired, and repairs it elsewhere."""

SETTLE_S = 1800.0
"""Time after the last problem; a transport that is open then counts as lost until then."""

SPREAD = 0.6
"""Standard deviation of the logarithm of a problem's duration: one in six lasts nearly twice as long as usual."""

STRUCK = frozenset({Phase.APPROACHING, Phase.CARRYING})
"""A vehicle has its problem on the way."""


@dataclass(frozen=True, slots=True)
class Sort:
    """A sort of problem.

    Attributes:
        about: the body's knowledge of it.
        usually_s: median duration, with a person who comes where one is needed.
    """

    about: Problem
    usually_s: float


SORTS: tuple[Sort, ...] = (
    Sort(Problem(kind=ProblemKind.LOAD, passes=False, needs_person=True, load_movable=True), 75.0),
    Sort(Problem(kind=ProblemKind.DRIVE, passes=False, needs_person=True), 1200.0),
    Sort(Problem(kind=ProblemKind.SENSOR, needs_person=True), 60.0),
    Sort(Problem(kind=ProblemKind.BATTERY, passes=False, needs_person=True), 600.0),
    Sort(Problem(kind=ProblemKind.WAY_BLOCKED), 30.0),
    Sort(Problem(kind=ProblemKind.LOST_POSITION, needs_person=True), 240.0),
    Sort(Problem(kind=ProblemKind.LINK, passes=True), 20.0),
    Sort(Problem(kind=ProblemKind.EMERGENCY_STOP, needs_person=True), 40.0),
    Sort(Problem(kind=ProblemKind.DOCK, passes=True), 25.0),
)
"""Our assumptions: there are no published times. A lost position lasts longer than vehicles believe at first, so that
they have something to learn."""


@dataclass(frozen=True, slots=True)
class Lost:
    """The cost of one problem.

    Attributes:
        after_s: how much later its transport was delivered than expected before.
        moved: whether another vehicle has taken it over.
    """

    kind: ProblemKind
    after_s: float
    moved: bool


async def strike(stage: Stage, told: bool) -> tuple[Lost, ...]:
    """Let vehicles have problems on their ways.

    Args:
        stage: the run.
        told: whether their bodies tell the kind and the details.
    """
    sorts, gaps, victims = stage.random("sorts"), stage.random("gaps"), stage.random("victims")
    struck: dict[str, tuple[ProblemKind, float]] = {}
    deck: list[Sort] = []
    carried: list[asyncio.Task[None]] = []
    async with asyncio.TaskGroup() as people:
        while stage.now_s() < stage.shift.duration_s:
            await asyncio.sleep(gaps.expovariate(1.0 / EVERY_S))
            busy = _busy(stage, struck)
            if not busy:
                continue
            # All sorts are equally frequent, and in the same order both times.
            deck = deck or sorts.sample(SORTS, len(SORTS))
            sort = deck.pop()
            lasts_s = sorts.lognormvariate(log(sort.usually_s), SPREAD)
            atv = victims.choice(sorted(busy))
            task, due_s = busy[atv]
            struck[task] = sort.about.kind, due_s
            problem = sort.about if told else NOTHING_KNOWN
            fault = stage.faults.begin(VehicleBroken(atv, sort.about.kind.value, problem))
            stage.factory.clock.call_at(stage.now_s() + lasts_s, partial(stage.faults.end, fault))
            if sort.about.needs_person and lasts_s > CARRIED_AFTER_S and stage.office is not None:
                carried.append(people.create_task(_carry_away(stage, stage.office, atv, lasts_s)))
        await stage.settle(SETTLE_S)
        for person in carried:
            person.cancel()
    return _lost(stage, struck)


async def _carry_away(stage: Stage, office: FloorOffice, atv: str, lasts_s: float) -> None:
    """Let people carry a vehicle away that is in the way of others, and bring it back mended."""
    at_s, away_s = stage.now_s() + CARRIED_AFTER_S, lasts_s - CARRIED_AFTER_S
    near = stage.witness.atvs[atv].node
    await Carriers(stage.factory, stage.faults, office).carry([Carrying(atv, at_s, away_s, near)])


def _busy(stage: Stage, struck: Mapping[str, object]) -> dict[str, tuple[str, float]]:
    """Vehicles on their way with an undisturbed transport, each with its expected end.

    A vehicle that is late already is left out. The cause of its delay, as an obstacle, is not the cost of its own
    problem. So is one with finished goods on board: they exist once, and wait for their carrier in any case.
    """
    busy: dict[str, tuple[str, float]] = {}
    for atv, heartbeat in stage.witness.atvs.items():
        task = heartbeat.task
        if task is None or task.due_s is None or heartbeat.status is not AtvStatus.WORKING:
            continue
        if task.due_s < stage.now_s() or (heartbeat.load and heartbeat.load not in stage.plant.materials):
            continue
        if task.phase in STRUCK and task.task not in struck and not stage.factory.vehicles[atv].problem:
            busy[atv] = task.task, task.due_s
    return busy


def _lost(stage: Stage, struck: Mapping[str, tuple[ProblemKind, float]]) -> tuple[Lost, ...]:
    closed = {seen.said.task: seen for seen in stage.witness.all(TaskClosed)}
    taken = {seen.said.task for seen in stage.witness.all(TookOver)}
    lost: list[Lost] = []
    for task, (kind, due_s) in struck.items():
        end = closed.get(task)
        if end is not None and end.said.outcome != "delivered":
            continue
        lost.append(Lost(kind, (end.at_s if end is not None else stage.now_s()) - due_s, task in taken))
    return tuple(lost)


def problems(seed: int, seeds: int = SEEDS, shift: Shift = SHIFT, plant: Plant | None = None) -> Findings:
    """Play the same problems twice with every seed: told in words alone, and by their kind."""
    ground = plant or default_plant()
    runs: dict[bool, list[Played[tuple[Lost, ...]]]] = {False: [], True: []}
    for number in range(seed, seed + seeds):
        for told, played in runs.items():
            played.append(play(shift, ground, number, partial(strike, told=told)))
    words, judged = (_by_kind(played.result or () for played in runs[told]) for told in (False, True))
    dead_s = tuple(_mean(found[ProblemKind.DRIVE]) for found in (words, judged))
    all_s = tuple(_mean([each for kind in found.values() for each in kind]) for found in (words, judged))
    return Findings(
        runs=(*runs[False], *runs[True]),
        checks=(
            Check(
                "Judged by their kind, problems cost less time than waited for alike",
                all_s[1] < all_s[0],
                f"{all_s[1]:.0f} s instead of {all_s[0]:.0f} s in the mean",
            ),
            Check(
                "A dead drive is handed over at once",
                dead_s[1] < dead_s[0],
                f"{dead_s[1]:.0f} s instead of {dead_s[0]:.0f} s",
            ),
        ),
        tables=(
            Table(
                "Time lost for one problem: mean, and how many of the transports were taken over",
                ("kind", "usually over after", "words alone", "taken over", "judged", "taken over"),
                tuple(
                    (
                        sort.about.kind.value.replace("_", " "),
                        f"{sort.usually_s:.0f} s",
                        *_cells(words[sort.about.kind]),
                        *_cells(judged[sort.about.kind]),
                    )
                    for sort in SORTS
                ),
            ),
        ),
    )


def _by_kind(told: Iterable[tuple[Lost, ...]]) -> Mapping[ProblemKind, list[Lost]]:
    found: defaultdict[ProblemKind, list[Lost]] = defaultdict(list)
    for lost in told:
        for each in lost:
            found[each.kind].append(each)
    return found


def _cells(lost: list[Lost]) -> tuple[str, str]:
    return f"{_mean(lost):.0f} s", f"{sum(each.moved for each in lost)} of {len(lost)}"


def _mean(lost: list[Lost]) -> float:
    return sum(each.after_s for each in lost) / len(lost) if lost else 0.0


PROBLEMS = Scenario(
    name="problems",
    shows="Time lost for each kind of problem, waited for alike and judged by its kind.",
    source="paper, 4.2 case 4: the problem will be evaluated first",
    claim="A problem is judged before it is waited for, and that saves time.",
    story=(
        f"{SEEDS} times {SHIFT.duration_s / 3600:g} hours of the default plant at {SHIFT.load:.0%} load. About every {EVERY_S:.0f} s a vehicle "
        "that is on its way with a transport, and has no goods on board that exist once, has a problem of some kind, which lasts as such problems "
        f"do. Where vehicles take up room, people carry away what they have not mended where it stands after {CARRIED_AFTER_S:.0f} s. "
        "Twice: the body has words for it alone, and the body tells the kind and what it knows."
    ),
    play=problems,
    elsewhere=lambda seed, site: problems(seed, 1, site.shift(SHIFT), site.ground),
)
