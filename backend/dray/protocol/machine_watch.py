"""Which machines can work, as their heartbeats tell it to the strategist (paper, case 1).

A machine has failed for its goals when it is silent, or when it has said for long that it is broken.
Nothing is lost by a wrong verdict but work: the gate lets every piece in once, whoever made it.
"""

from __future__ import annotations

from collections.abc import Iterable

from dray.messages import MachineHeartbeat, MachineStatus, Newcomer

GOAL_SILENCE_S = 15.0
"""How long a machine may not name a goal before it has lost it. A machine that holds goals beats at 1 Hz,
so fifteen heartbeats are missing in a row; and its software starts again in less."""

BREAKDOWN_S = 600.0
"""How long a machine may be broken and keep its goals. A technician mends most breakdowns in less, and
what was made before is carried away meanwhile."""


MAX_NEWCOMERS = 100
"""Machines that have come to a plant whose file did not know them: more than anybody sets up before writing
them into it."""


class Seen:
    """What was last heard of one machine."""

    __slots__ = ("broken_s", "heard_s", "newest")

    def __init__(self, heard_s: float) -> None:
        self.heard_s = heard_s
        self.newest = (0, 0)
        """Incarnation and number of the newest heartbeat."""
        self.broken_s: float | None = None
        """Since when it says that it is broken; None while it works."""


class MachineWatch:
    """All machines of one plant, and those that have come since its file was written.

    Args:
        machines: the ids of those in the plant file.
        now_s: when the watch begins; until they have had time to speak all are believed to live.
    """

    def __init__(self, machines: Iterable[str], now_s: float) -> None:
        self._seen = {machine: Seen(now_s) for machine in machines}
        self._newcomers: dict[str, Newcomer] = {}

    def hear(self, heartbeat: MachineHeartbeat, now_s: float) -> bool:
        """Note a heartbeat; False when it is older than one that was heard, or of no machine here."""
        seen = self._seen.get(heartbeat.machine) or self._welcome(heartbeat, now_s)
        order = (heartbeat.incarnation, heartbeat.seq)
        if seen is None or order <= seen.newest:
            return False
        seen.newest, seen.heard_s = order, now_s
        if heartbeat.status is not MachineStatus.ERROR:
            seen.broken_s = None
        elif seen.broken_s is None:
            seen.broken_s = now_s
        return True

    def newcomers_for(self, product: str) -> tuple[str, ...]:
        """The machines that have come since and can make a product."""
        return tuple(
            machine
            for machine, newcomer in self._newcomers.items()
            if any(making.product == product for making in newcomer.makes)
        )

    def is_fit(self, machine: str, now_s: float) -> bool:
        """Whether it lives and works."""
        return not self.trouble(machine, now_s)

    def trouble(self, machine: str, now_s: float) -> str:
        """What is the matter with a machine, in words; empty when it lives and works."""
        seen = self._seen.get(machine)
        # A newcomer that took a goal in an earlier life of the strategist may never have been heard in this one.
        if seen is None or now_s >= seen.heard_s + GOAL_SILENCE_S:
            return "silent"
        return "broken" if seen.broken_s is not None else ""

    def is_broken_for_long(self, machine: str, now_s: float) -> bool:
        """Whether it has been broken for longer than anybody waits for."""
        seen = self._seen.get(machine)
        broken_s = None if seen is None else seen.broken_s
        return broken_s is not None and now_s >= broken_s + BREAKDOWN_S

    def _welcome(self, heartbeat: MachineHeartbeat, now_s: float) -> Seen | None:
        """Begin to watch a machine that the plant file does not know, if it says what it is."""
        newcomer = heartbeat.newcomer
        if newcomer is None or len(self._newcomers) >= MAX_NEWCOMERS:
            return None
        self._newcomers[heartbeat.machine] = newcomer
        seen = self._seen[heartbeat.machine] = Seen(now_s)
        return seen
