"""Closures of a run: places that a manager closes, makes slow or one-way, and the times."""

from __future__ import annotations

from math import cos, pi, sin
from random import Random

from dray.messages import Closure, ClosureKind
from dray.messages.floor.closure import MAX_CORNERS
from dray.plant import Plant
from dray_sim.people.floor_manager import NAME, Closing

AT_ONCE = (1, 8)
"""Closures in a run, from and to."""

LASTS_S = (10.0, 240.0)

SLOW_MPS = (0.1, 0.8)

KINDS = {ClosureKind.CLOSED: 6, ClosureKind.SLOW: 2, ClosureKind.ONE_WAY: 2}
"""Relative frequency of each kind."""

EXTENTS = {"lane": 5, "node": 3, "area": 1}

DRAWN_FRAC = 0.5
"""The part of the runs with closures in which somebody draws an outline on the floor, too."""

DRAWN_M = (1.0, 6.0)
"""Range of the distances of its corners from a node."""


def draw_closings(plant: Plant, random: Random, until_s: float) -> tuple[Closing, ...]:
    """The closures of one run, any lane, node or area at any time; all have ended by `until_s`."""
    closings = []
    for number in range(random.randint(*AT_ONCE)):
        at_s = random.uniform(0.0, until_s)
        ends_s = min(until_s, at_s + random.uniform(*LASTS_S))
        closure = _draw(plant, random, f"closure-{number + 1}")
        closings.append(Closing(closure, at_s, ends_s, tells_end=random.random() < 0.5))
    return tuple(closings)


def draw_outline(plant: Plant, random: Random, until_s: float) -> tuple[Closing, ...]:
    """Perhaps one more: closed or slow, a polygon around a node."""
    if random.random() >= DRAWN_FRAC:
        return ()
    middle = plant.nodes[random.choice(tuple(plant.nodes))]
    turns = sorted(random.uniform(0.0, 2.0 * pi) for _ in range(random.randint(3, MAX_CORNERS)))
    outline = tuple(
        (round(middle.x_m + far_m * cos(turn), 2), round(middle.y_m + far_m * sin(turn), 2))
        for turn in turns
        for far_m in (random.uniform(*DRAWN_M),)
    )
    kind = random.choice((ClosureKind.CLOSED, ClosureKind.SLOW))
    speed_mps = random.uniform(*SLOW_MPS) if kind is ClosureKind.SLOW else None
    at_s = random.uniform(0.0, until_s)
    ends_s = min(until_s, at_s + random.uniform(*LASTS_S))
    closure = Closure("closure-drawn", kind, NAME, outline=outline, speed_mps=speed_mps)
    return (Closing(closure, at_s, ends_s, tells_end=random.random() < 0.5),)


def _draw(plant: Plant, random: Random, name: str) -> Closure:
    kind = random.choices(tuple(KINDS), tuple(KINDS.values()))[0]
    extent = random.choices(tuple(EXTENTS), tuple(EXTENTS.values()))[0]
    speed_mps = random.uniform(*SLOW_MPS) if kind is ClosureKind.SLOW else None
    lane = random.choice(plant.lanes)
    if kind is ClosureKind.ONE_WAY or extent == "lane" or (extent == "area" and not plant.areas):
        return Closure(name, kind, NAME, start=lane.start, end=lane.end, speed_mps=speed_mps)
    if extent == "node":
        return Closure(name, kind, NAME, node=random.choice(tuple(plant.nodes)), speed_mps=speed_mps)
    return Closure(name, kind, NAME, area=random.choice(tuple(plant.areas)), speed_mps=speed_mps)
