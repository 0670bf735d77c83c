"""Which operators a call for help asks next, and how long it waits: pure arithmetic.

    round 1    the nearest operator who is free, responsible for the place, and helps with such a problem
    round 2    the next three who are free and help with it, responsible for any place
    round 3    all others on duty, even busy ones

A round without operators left passes to the next at once. In one pass each operator is asked once. After the third
round the call rests, and begins again. Silence declines.
"""

from __future__ import annotations

from collections.abc import Container, Iterable
from math import hypot

from dray.messages import DutyStatus, OperatorHeartbeat, ProblemKind
from dray.messages.people.call import ASKED_MAX
from dray.plant import Plant
from dray.plant.floor.geometry import box_of

ASKED_IN_ROUND = (1, 3, ASKED_MAX)
"""Operators asked per round: one at first, so that nobody runs for nothing."""

ANSWER_S = 20.0
"""Answer timeout (s): time to put something down, read and touch. Three rounds are a minute, less than most tasks can wait."""

SAY_EVERY_S = 5.0
"""Interval of repetitions (s), as an idle agent's heartbeats: an operator that missed the call hears it then."""

LATE_S = 15.0
"""Lateness of a promised arrival before others are asked (s)."""

REST_S, REST_MAX_S = 20.0, 120.0
"""Rest after a pass without an answer, and its maximum (s); it doubles after each further pass."""

NEAR_M = 1000.0
"""Assumed distance of an operator without a known place (m): farther than anybody in one hall."""


def next_asked(
    known: Iterable[OperatorHeartbeat],
    plant: Plant,
    place_m: tuple[float, float],
    kind: ProblemKind,
    round_: int,
    spared: Container[str],
) -> tuple[int, tuple[str, ...]]:
    """The operators to ask, the nearest first, and their round.

    Args:
        known: the operators on duty.
        plant: its areas and stations.
        place_m: where help is needed (x, y) in m.
        kind: the kind of the problem.
        round_: the first round to try, from 1.
        spared: operators not to ask.

    Returns:
        The round and the operators; none if no operator is left in any round.
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
    """Rest of a call after `passes` (at least 1) without an answer (s)."""
    return float(min(REST_S * 2.0 ** min(passes - 1, 10), REST_MAX_S))


def is_there_for(operator: OperatorHeartbeat, areas: frozenset[str]) -> bool:
    """Whether an operator is responsible for a place in these areas; a place outside of all is everybody's."""
    return operator.everywhere or not areas or not areas.isdisjoint(operator.areas)


def away_m(operator: OperatorHeartbeat, plant: Plant, place_m: tuple[float, float]) -> float:
    """Straight distance of an operator (m): from the station, else from the nearest of the areas."""
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
