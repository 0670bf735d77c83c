"""Waiting places of vehicles without a dwell point: nodes of the roads that no other vehicle needs.

A plant with fewer chargers and parking places than vehicles has some that stand in the lanes. While they stand at the
nodes named first here, all other vehicles still get from every dock to every other, and each of them gets away and
back. Where these are too few, some vehicles are a *reserve*, which takes no work that others can do. The reserve may
shut off some chargers and parking places, in which others of the reserve stand, but no dock for goods. Where that is
too little as well, the floor is too small for the fleet: then the least used nodes that are before no dock follow.
Every agent computes the same nodes, and vehicles claim them as they claim parking places.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from heapq import heappop, heappush

import msgspec

from dray.plant.model import Node
from dray.plant.roads import Roads


class SparePlaces(msgspec.Struct, frozen=True):
    """Nodes where vehicles wait."""

    clear: tuple[str, ...]
    """Nodes that are in no vehicle's way."""
    others: tuple[str, ...]
    """Nodes that are in a vehicle's way, for vehicles without a better one."""
    reserve: tuple[str, ...] = ()
    """Nodes of the reserve: while vehicles stand there, all docks for goods reach one another, and those in `shut` do
    not."""
    shut: frozenset[str] = frozenset()
    """Nodes of chargers and parking places that the reserve shuts off: a vehicle there belongs to it."""

    @property
    def all(self) -> tuple[str, ...]:
        """All of them, the better ones first."""
        return (*self.clear, *self.reserve, *self.others)

    @property
    def reserve_size(self) -> int:
        """Most vehicles in the reserve at one time."""
        return len(self.reserve) + len(self.shut)

    def holds_back_from(self, able: int) -> bool:
        """Whether the reserve leaves work for so many able vehicles to others: a third of them is outside of the reserve."""
        return 2 * able >= 3 * self.reserve_size

    def is_reserve(self, node: str) -> bool:
        """Whether a vehicle that waits at a node belongs to the reserve."""
        return node in self.shut or node in self.reserve


SOURCES = 24
"""Docks from which ways are counted; in a large plant every further one changes little."""

TRIED_PER_PLACE = 6
"""Nodes that are looked at for each place that is needed: the least used first."""

LEFT_FRAC = 0.5
"""Part of the chargers and parking places that no reserve shuts off."""


def spare_nodes(
    nodes: Mapping[str, Node],
    roads: Iterable[Roads],
    stops: Iterable[str],
    docks: Iterable[str],
    needed: int,
    goods: Iterable[str] = (),
) -> SparePlaces:
    """The least used nodes at which vehicles can wait, at most as many as are needed.

    Args:
        nodes: of the floor, in file order, which breaks ties.
        roads: of each type of vehicle that drives.
        stops: where vehicles may stand.
        docks: where they dock, charge and park.
        needed: how many nodes are asked for.
        goods: those of the docks where goods are handed over; none for a floor without a reserve.
    """
    every, docked, stops = tuple(roads), tuple(dict.fromkeys(docks)), tuple(stops)
    if needed <= 0 or not docked:
        return SparePlaces((), ())
    entries = {entry for dock in docked for one in every for entry in _dock_entries(one, dock)}
    used = _use(every[0], docked)
    order = {node: number for number, node in enumerate(nodes)}
    free = sorted(
        (node for node in stops if node not in docked and node not in entries),
        key=lambda node: (used.get(node, 0), order[node]),
    )
    floors = [_Floor(one) for one in every]
    clear: list[str] = []
    for node in free[: TRIED_PER_PLACE * needed]:
        if len(clear) == needed:
            break
        if all(_leaves_all(one, docked, (*clear, node)) for one in floors):
            clear.append(node)
    reserve, shut = _reserve(floors, docked, tuple(dict.fromkeys(goods)), stops, clear, every, used, needed)
    others = [node for node in free if node not in clear and node not in reserve]
    rest = needed - len(clear) - len(reserve)
    return SparePlaces(tuple(clear), tuple(others[:rest]), tuple(reserve), shut)


def _reserve(
    floors: list[_Floor],
    docked: tuple[str, ...],
    goods: tuple[str, ...],
    stops: tuple[str, ...],
    clear: list[str],
    every: tuple[Roads, ...],
    used: Mapping[str, int],
    needed: int,
) -> tuple[list[str], frozenset[str]]:
    """Nodes for the rest of the fleet, and the docks without goods that vehicles there shut off.

    Each next node shuts off the fewest docks, and is the least used among equals.
    """
    dwells = frozenset(docked).difference(goods)
    entries = {entry for dock in goods for one in every for entry in _dock_entries(one, dock)}
    tried = [node for node in stops if node not in docked and node not in entries and node not in clear]
    tried.sort(key=lambda node: used.get(node, 0))
    del tried[TRIED_PER_PLACE * needed :]
    reserve: list[str] = []
    shut: frozenset[str] = frozenset()
    while goods and len(clear) + len(reserve) < needed:
        best: tuple[int, str, frozenset[str]] | None = None
        for node in tried:
            reached = _reached(floors, goods, (*clear, *reserve, node))
            lost = dwells - reached
            if node not in reserve and reached.issuperset(goods) and (best is None or len(lost) < best[0]):
                best = len(lost), node, lost
        if best is None or len(dwells) - best[0] < LEFT_FRAC * len(dwells):
            break
        reserve.append(best[1])
        shut = best[2]
    return reserve, shut


def _reached(floors: list[_Floor], goods: tuple[str, ...], taken: tuple[str, ...]) -> set[str]:
    """All nodes to which every vehicle gets from a dock for goods, and back, while others stand at some nodes."""
    closed = frozenset(taken)
    ways = [_flood(goods[0], closed, onward) for one in floors for onward in (one.after, one.before)]
    return set.intersection(*ways)


def _dock_entries(roads: Roads, dock: str) -> Iterable[str]:
    """The nodes before a dock at a spur, where a waiting vehicle keeps others from it."""
    before = {lane.start for lane in roads.entering[dock]}
    after = {lane.end for lane in roads.leaving[dock]}
    return before | after if len(before) == 1 or len(after) == 1 else ()


def _use(roads: Roads, docks: tuple[str, ...]) -> dict[str, int]:
    """Number of the shortest ways between docks over each node."""
    step = max(1, -(-len(docks) // SOURCES))
    used: dict[str, int] = {}
    for source in docks[::step]:
        before = _shortest(roads, source)
        for dock in docks:
            node = before.get(dock, "")
            while node and node != source:
                used[node] = used.get(node, 0) + 1
                node = before[node]
    return used


def _shortest(roads: Roads, source: str) -> dict[str, str]:
    """Node -> the one before it on the shortest way from a source."""
    before: dict[str, str] = {}
    open_nodes = [(0.0, source, "")]
    while open_nodes:
        so_far_m, node, came_from = heappop(open_nodes)
        if node in before:
            continue
        before[node] = came_from
        for lane in roads.leaving[node]:
            if lane.end not in before:
                heappush(open_nodes, (so_far_m + lane.length_m, lane.end, node))
    return before


class _Floor:
    """The next and the previous nodes of each node."""

    def __init__(self, roads: Roads) -> None:
        self.after = {node: [lane.end for lane in lanes] for node, lanes in roads.leaving.items()}
        self.before = {node: [lane.start for lane in lanes] for node, lanes in roads.entering.items()}


def _leaves_all(floor: _Floor, docks: tuple[str, ...], taken: tuple[str, ...]) -> bool:
    """Whether some docks reach one another while vehicles stand at some nodes, and these get away and back."""
    shut = frozenset(taken)
    there = _flood(docks[0], shut, floor.after)
    if not there.issuperset(docks):
        return False
    back = _flood(docks[0], shut, floor.before)
    if not back.issuperset(docks):
        return False
    return all(
        not there.isdisjoint(floor.before[node]) and not back.isdisjoint(floor.after[node]) for node in taken
    )


def _flood(start: str, shut: frozenset[str], onward: Mapping[str, Iterable[str]]) -> set[str]:
    """All nodes to which lanes lead from one, without those where somebody stands."""
    found, coming = {start}, [start]
    while coming:
        for node in onward[coming.pop()]:
            if node not in found and node not in shut:
                found.add(node)
                coming.append(node)
    return found
