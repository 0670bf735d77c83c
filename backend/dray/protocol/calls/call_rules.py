"""Whom a call for help asks next, and how long it waits: pure arithmetic.

    round 1    the nearest one who is free, is there for the place, and helps with such a problem
    round 2    the next three who are free and help with it, wherever they are there for
    round 3    everybody else who is on duty, busy or not

A round in which nobody is left goes over to the next at once. In one pass nobody is asked twice; after the third round the call rests, and
begins anew. Silence declines.
"""

from __future__ import annotations

from collections.abc import Container, Iterable
from math import hypot

from dray.messages import DutyStatus, OperatorHeartbeat, ProblemKind
from dray.messages.people.call import ASKED_MAX
from dray.plant import Plant
from dray.plant.floor.geometry import box_of

ASKED_IN_ROUND = (1, 3, ASKED_MAX)
"""How many are asked at a time: one at first, so that nobody runs for nothing."""

ANSWER_S = 20.0
"""Time to put something down, read and touch. Three rounds of it are a minute, less than most tasks can wait."""

SAY_EVERY_S = 5.0
"""A call is said as often as an idle agent beats: whoever has missed it hears it then."""

LATE_S = 15.0
"""So much later than promised somebody may come before others are asked."""

REST_S, REST_MAX_S = 20.0, 120.0
"""After a pass in which nobody has taken it; twice as long after each further one."""

NEAR_M = 1000.0
"""How far away somebody counts of whom nothing is told: farther than anybody in one hall."""


def next_asked(
    known: Iterable[OperatorHeartbeat],
    plant: Plant,
    place_m: tuple[float, float],
    kind: ProblemKind,
    round_: int,
    spared: Container[str],
) -> tuple[int, tuple[str, ...]]:
    """Whom to ask, the nearest first, and in which round that is.

    Args:
        known: who is on duty now.
        plant: where areas and stations are.
        place_m: where help is needed (x, y).
        kind: of the problem.
        round_: the first to look at, from 1.
        spared: who is not to be asked.

    Returns:
        The round and the operators; none when nobody is left in any round.
    """
    here = frozenset(plant.areas_at(*place_m))
    there = [each for each in known if each.operator not in spared and each.status is not DutyStatus.BREAK]
    for number in range(round_, len(ASKED_IN_ROUND) + 1):
        fitting = [each for each in there if _fits(each, here, kind, number)]
        if fitting:
            fitting.sort(key=lambda each: (_is_busy(each), away_m(each, plant, place_m), each.operator))
            return number, tuple(each.operator for each in fitting[: ASKED_IN_ROUND[number - 1]])
    return len(ASKED_IN_ROUND), ()


def rest_s(passes: int) -> float:
    """How long a call rests after so many passes, at least 1, in which nobody has taken it."""
    return float(min(REST_S * 2.0 ** min(passes - 1, 10), REST_MAX_S))


def is_there_for(operator: OperatorHeartbeat, areas: frozenset[str]) -> bool:
    """Whether an operator is on duty for a place in these areas; a place outside of all is everybody's."""
    return operator.everywhere or not areas or not areas.isdisjoint(operator.areas)


def away_m(operator: OperatorHeartbeat, plant: Plant, place_m: tuple[float, float]) -> float:
    """How far away an operator is as the crow flies: from the station, else from the nearest of the areas."""
    x_m, y_m = place_m
    at = [plant.position_of(spec.id) for spec in plant.machines.values() if spec.station == operator.station]
    if not at or not operator.station:
        boxes = [box_of(plant.areas[area].polygon) for area in operator.areas if area in plant.areas]
        at = [((left_m + right_m) / 2, (low_m + high_m) / 2) for left_m, low_m, right_m, high_m in boxes]
    return min((hypot(x - x_m, y - y_m) for x, y in at), default=NEAR_M)


def _fits(operator: OperatorHeartbeat, here: frozenset[str], kind: ProblemKind, round_: int) -> bool:
    if round_ == len(ASKED_IN_ROUND):
        return True
    able = not operator.helps_with or kind in operator.helps_with
    return able and not _is_busy(operator) and (round_ > 1 or is_there_for(operator, here))


def _is_busy(operator: OperatorHeartbeat) -> bool:
    return operator.status is DutyStatus.BUSY
