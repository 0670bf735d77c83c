"""Halls and their lanes: rings, trees, combs, grids and scattered crossings, some of them one-way."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from math import cos, hypot, pi, sin
from random import Random

MARGIN_M = 6.0
"""Distance from a crossing to the wall: places stand there."""

GATE_M = 12.0
"""Distance between halls."""

LEAST_GAP_M = 2.5
"""Between two crossings."""

ONE_WAY_FRAC = (0.0, 0.0, 0.2, 0.5)
"""Fractions of a plant's lanes that may lose one of their directions."""

SPEEDS_MPS = (0.5, 0.8, 1.0, 1.5, 2.0)


@dataclass(slots=True)
class Network:
    """Nodes and lanes in the making; always strongly connected.

    Attributes:
        spots: position of every node (x_m, y_m).
        lanes: both directions of every lane, with its speed limit (m/s).
        crossings: nodes beside which places may be put, by hall.
        width_m, height_m: of the floor.
    """

    spots: dict[str, tuple[float, float]] = field(default_factory=dict)
    lanes: dict[tuple[str, str], float] = field(default_factory=dict)
    crossings: list[list[str]] = field(default_factory=list)
    width_m: float = 0.0
    height_m: float = 0.0

    def node(self, name: str, x_m: float, y_m: float) -> str:
        """Add a node."""
        self.spots[name] = (round(x_m, 2), round(y_m, 2))
        return name

    def join(self, start: str, end: str, speed_mps: float) -> None:
        """A lane in both directions; harmless when there is one."""
        if start != end:
            self.lanes.setdefault((start, end), speed_mps)
            self.lanes.setdefault((end, start), speed_mps)

    def narrow(self, start: str, end: str) -> bool:
        """Take one direction of a lane away, where another way leads there."""
        speed_mps = self.lanes.pop((start, end))
        if self._leads(start, end):
            return True
        self.lanes[start, end] = speed_mps
        return False

    def _leads(self, start: str, end: str) -> bool:
        after: dict[str, list[str]] = {}
        for here, there in self.lanes:
            after.setdefault(here, []).append(there)
        seen, waiting = {start}, [start]
        while waiting:
            for there in after.get(waiting.pop(), ()):
                if there == end:
                    return True
                if there not in seen:
                    seen.add(there)
                    waiting.append(there)
        return False


def draw_lanes(random: Random, places: int) -> Network:
    """Halls side by side with about as many crossings as there are places to put beside them."""
    network = Network()
    halls = random.choice((1, 1, 1, 2, 2, 3))
    left_m = 0.0
    for hall in range(halls):
        count = max(3, round(places / halls * random.uniform(0.4, 1.1)))
        pitch_m = random.uniform(4.0, 12.0)
        shape = random.choice((_ring, _tree, _comb, _grid, _scatter))
        spots = list(shape(random, count))
        low_x, low_y = min(x for x, _ in spots), min(y for _, y in spots)
        names = [
            network.node(
                f"h{hall}.{number}",
                left_m + MARGIN_M + (x - low_x) * pitch_m,
                MARGIN_M + (y - low_y) * pitch_m,
            )
            for number, (x, y) in enumerate(spots)
        ]
        network.crossings.append(names)
        _span(network, random, names, extra=random.choice((0.0, 0.1, 0.4)))
        left_m = max(network.spots[name][0] for name in names) + GATE_M
    for before, after in zip(network.crossings, network.crossings[1:], strict=False):
        for _ in range(random.choice((1, 1, 2))):
            east = max(random.sample(before, min(4, len(before))), key=lambda name: network.spots[name])
            west = min(random.sample(after, min(4, len(after))), key=lambda name: network.spots[name])
            network.join(east, west, random.choice(SPEEDS_MPS))
    network.width_m = max(x for x, _ in network.spots.values()) + MARGIN_M
    network.height_m = max(y for _, y in network.spots.values()) + MARGIN_M
    return network


def make_one_way(network: Network, random: Random) -> None:
    """Some lanes lose a direction, never the last way to anywhere."""
    frac = random.choice(ONE_WAY_FRAC)
    for start, end in sorted(network.lanes):
        if (end, start) in network.lanes and random.random() < frac:
            network.narrow(start, end)


# --- shapes: crossings on a raster of about one unit ----------------------------------------------------


def _ring(random: Random, count: int) -> Iterator[tuple[float, float]]:
    radius = count / (2.0 * pi)
    flat = random.uniform(0.5, 1.0)
    for number in range(count):
        angle = 2.0 * pi * number / count
        yield radius * cos(angle), flat * radius * sin(angle)


def _tree(random: Random, count: int) -> Iterator[tuple[float, float]]:
    taken = {(0, 0)}
    while len(taken) < count:
        x, y = random.choice(sorted(taken))
        step = random.choice(((1, 0), (0, 1), (-1, 0), (0, -1)))
        taken.add((x + step[0], y + step[1]))
    for x, y in sorted(taken):
        yield float(x), float(y)


def _comb(random: Random, count: int) -> Iterator[tuple[float, float]]:
    teeth = max(1, round(count ** random.uniform(0.3, 0.7)))
    for number in range(count):
        yield float(number % teeth) * 1.5, float(number // teeth)


def _grid(random: Random, count: int) -> Iterator[tuple[float, float]]:
    columns = max(2, round((count * random.uniform(0.5, 3.0)) ** 0.5))
    for number in range(count):
        yield float(number % columns), float(number // columns)


def _scatter(random: Random, count: int) -> Iterator[tuple[float, float]]:
    side = count**0.5 * 1.2
    spots: list[tuple[float, float]] = []
    for _ in range(count * 30):
        spot = random.uniform(0.0, side), random.uniform(0.0, side)
        if all(hypot(spot[0] - x, spot[1] - y) > 0.65 for x, y in spots):
            spots.append(spot)
        if len(spots) == count:
            break
    yield from spots


def _span(network: Network, random: Random, names: list[str], extra: float) -> None:
    """The shortest tree over all of them, and some of the next shortest lanes beside it."""
    spots = network.spots
    pairs = sorted(
        (hypot(spots[a][0] - spots[b][0], spots[a][1] - spots[b][1]), a, b)
        for index, a in enumerate(names)
        for b in names[index + 1 :]
    )
    part = {name: name for name in names}

    def root(name: str) -> str:
        while part[name] != name:
            name = part[name]
        return name

    longest_m = 0.0
    for length_m, a, b in pairs:
        if root(a) != root(b):
            part[root(a)] = root(b)
            network.join(a, b, random.choice(SPEEDS_MPS))
            longest_m = max(longest_m, length_m)
    for length_m, a, b in pairs:
        if length_m <= longest_m * 1.2 and random.random() < extra:
            network.join(a, b, random.choice(SPEEDS_MPS))
