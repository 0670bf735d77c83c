"""The condition of the network between any two agents: the active faults by link.

Pure bookkeeping: chance and time are the network's business.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from typing import assert_never

from dray_sim.network.coverage import Coverage, Hole
from dray_sim.network.faults import (
    AccessPointDown,
    CoverageHole,
    LinkTrouble,
    NetworkFault,
    Partition,
    RadioCut,
    WlanCut,
)

MAX_LINKS = 100_000
"""Links whose troubles are remembered: those of a plant of three hundred agents that all talk to one another."""

Troubles = tuple[LinkTrouble, ...]


class Links:
    """The active faults of a network.

    Args:
        coverage: of the WLAN while nothing is wrong.

    Attributes:
        coverage: of the WLAN as it is now.
        wlan_cut, radio_cut: agents without WLAN or radio, for any coverage.
    """

    def __init__(self, coverage: Coverage) -> None:
        self._faults: list[NetworkFault] = []
        self._mended: list[NetworkFault] = []
        """Active faults that a person has repaired: they only await their end."""
        self._plain = coverage
        self.coverage = coverage
        self.wlan_cut: frozenset[str] = frozenset()
        self.radio_cut: frozenset[str] = frozenset()
        self._troubles: list[tuple[Callable[[str], bool], Callable[[str], bool], LinkTrouble]] = []
        self._partitions: list[list[list[Callable[[str], bool]]]] = []
        self._known: dict[tuple[str, str], Troubles | None] = {}

    @property
    def quiet(self) -> bool:
        """Whether there is no fault, and every place has WLAN."""
        return not self._faults and self.coverage.perfect

    @property
    def access_points(self) -> tuple[str, ...]:
        """All that there are, up or down."""
        return tuple(point.id for point in self._plain.access_points)

    def cover(self, coverage: Coverage) -> None:
        """Replace the coverage; holes and access points that are faults stay so."""
        self._plain = coverage
        self._reckon()

    def begin(self, fault: NetworkFault) -> None:
        """Begin a fault; the same one begun twice must end twice."""
        self._faults.append(fault)
        self._reckon()

    def end(self, fault: NetworkFault) -> None:
        """End a fault.

        Raises:
            ValueError: this fault is not active.
        """
        if fault in self._mended:
            self._mended.remove(fault)
            return
        self._faults.remove(fault)
        self._reckon()

    def plug_in(self, agent: str) -> bool:
        """A person has repaired an agent's own WLAN; returns whether it was cut."""
        cuts = [fault for fault in self._faults if fault == WlanCut(agent)]
        self._mended += cuts
        self._faults = [fault for fault in self._faults if fault not in cuts]
        self._reckon()
        return bool(cuts)

    def troubles(self, sender: str, receiver: str) -> Troubles | None:
        """The troubles of messages on this link; None when none gets through."""
        pair = (sender, receiver)
        if pair in self._known:
            return self._known[pair]
        if len(self._known) >= MAX_LINKS:
            self._known.clear()
        found = self._known[pair] = self._find(sender, receiver)
        return found

    def _find(self, sender: str, receiver: str) -> Troubles | None:
        if sender == receiver:
            return ()
        if any(_group_of(sender, groups) != _group_of(receiver, groups) for groups in self._partitions):
            return None
        return tuple(trouble for from_, to, trouble in self._troubles if from_(sender) and to(receiver))

    def _reckon(self) -> None:
        """Precompute frequent answers from the faults."""
        wlan_cut, radio_cut, holes, down = [], [], [], []
        self._troubles, self._partitions = [], []
        self._known.clear()
        for fault in self._faults:
            match fault:
                case WlanCut(agent):
                    wlan_cut.append(agent)
                case RadioCut(agent):
                    radio_cut.append(agent)
                case LinkTrouble(sender, receiver):
                    self._troubles.append((agent_pattern(sender), agent_pattern(receiver), fault))
                case Partition(groups):
                    self._partitions.append([_patterns(group) for group in groups])
                case CoverageHole(x_m, y_m, radius_m):
                    holes.append(Hole(x_m, y_m, radius_m))
                case AccessPointDown(access_point):
                    down.append(access_point)
                case _:
                    assert_never(fault)
        # They are only asked for membership, so their order does not matter.
        self.wlan_cut, self.radio_cut = frozenset(wlan_cut), frozenset(radio_cut)
        self.coverage = self._plain.with_faults(holes, down)


def agent_pattern(pattern: str) -> Callable[[str], bool]:
    """A matcher of agents' ids: ``*`` is any number of characters, everything else is itself."""
    if "*" not in pattern:
        return pattern.__eq__
    match = re.compile(".*".join(map(re.escape, pattern.split("*")))).fullmatch
    return lambda agent: match(agent) is not None


def _patterns(group: Iterable[str]) -> list[Callable[[str], bool]]:
    return [agent_pattern(pattern) for pattern in group]


def _group_of(agent: str, groups: list[list[Callable[[str], bool]]]) -> int:
    """The first group that names an agent; all that are in none are in one more."""
    for number, patterns in enumerate(groups):
        if any(matches(agent) for matches in patterns):
            return number
    return len(groups)
