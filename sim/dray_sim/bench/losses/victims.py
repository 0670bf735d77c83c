"""Victims: which process is killed next, and what it is doing at that moment."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from random import Random

from dray.cli.fleet.folder import GATEWAY, HISTORIAN
from dray.messages import AtvHeartbeat, MachineHeartbeat, Phase
from dray.messages.keys import STRATEGIST


class Kind(StrEnum):
    """The activity of a process when it was killed.

    The database's turn is before that of processes that cannot start without it: it is not killed while they are
    away.
    """

    IDLE = "vehicle without a task"
    FETCHING = "vehicle before its load"
    LOADED = "vehicle with a load"
    WATCHING = "secondary"
    MACHINE = "machine"
    STRATEGIST = "strategist"
    DATABASE = "database"
    HISTORIAN = "historian"
    GATEWAY = "gateway"
    CREW_MACHINE = "machine with its vehicles"
    CREW_VEHICLE = "vehicle with its machine"
    VEHICLE_AWAY = "vehicle that stays away"
    MACHINE_AWAY = "machine that stays away"


STAYS_AWAY: Mapping[Kind, Kind] = {
    Kind.FETCHING: Kind.VEHICLE_AWAY,
    Kind.LOADED: Kind.VEHICLE_AWAY,
    Kind.MACHINE: Kind.MACHINE_AWAY,
}
"""The kind of a victim with work when it is not restarted for a long time."""

LASTING = frozenset(STAYS_AWAY.values())
"""Each of these kinds has a fixed number of turns, and chance never draws it: its victims are away for long."""


@dataclass(frozen=True, slots=True)
class Victim:
    """A process that may be killed.

    Attributes:
        name: its agent's.
        kind: its activity at this moment, as its heartbeat says.
        work: the task that it carries, the tasks that it watches, or the goals that it makes.
        crew: processes that are killed at the same moment: both sides of a contract lose their memory of it.
    """

    name: str
    kind: Kind
    work: tuple[str, ...] = ()
    crew: tuple[Victim, ...] = ()


DATABASE = Victim("database", Kind.DATABASE)

OFFICES: Mapping[str, Kind] = {
    STRATEGIST: Kind.STRATEGIST,
    HISTORIAN: Kind.HISTORIAN,
    GATEWAY: Kind.GATEWAY,
}
"""The processes of which there is one."""

_BEFORE_THE_LOAD = frozenset({Phase.APPROACHING, Phase.LOADING})


def vehicle(heartbeat: AtvHeartbeat) -> Victim:
    """A vehicle, by its last word."""
    task = heartbeat.task
    if task is not None:
        before = task.phase in _BEFORE_THE_LOAD and not heartbeat.load
        return Victim(heartbeat.atv, Kind.FETCHING if before else Kind.LOADED, (task.task,))
    if heartbeat.watches:
        return Victim(heartbeat.atv, Kind.WATCHING, tuple(brief.task for brief in heartbeat.watches))
    return Victim(heartbeat.atv, Kind.IDLE)


def machine(heartbeat: MachineHeartbeat) -> Victim:
    """A machine, by its last word."""
    return Victim(heartbeat.machine, Kind.MACHINE, tuple(brief.goal for brief in heartbeat.goals))


def crew(heartbeat: MachineHeartbeat, vehicles: Iterable[AtvHeartbeat]) -> Victim | None:
    """A machine with all vehicles that carry for it, by their last heartbeats; None when none does."""
    members = tuple(
        Victim(each.atv, Kind.CREW_VEHICLE, (each.task.task,))
        for each in vehicles
        if each.task is not None and each.task.coordinator == heartbeat.machine
    )
    if not members:
        return None
    return replace(machine(heartbeat), kind=Kind.CREW_MACHINE, crew=members)


class Rota:
    """The order of the kills: every kind so many times in turn, then kinds drawn by chance.

    Args:
        random: the only source of chance.
        turns: how often it is each kind's turn.
    """

    def __init__(self, random: Random, turns: Mapping[Kind, int]) -> None:
        self._random = random
        rounds = range(max(turns.values()))
        self._turns = [kind for turn in rounds for kind in Kind if turn < turns.get(kind, 0)]

    def choose(self, living: Iterable[Victim]) -> Victim | None:
        """The next victim; None when no process is alive."""
        chosen = self._of_the_next_kind(there := sorted(living, key=lambda victim: victim.name))
        others = [victim for victim in there if victim.kind not in LASTING]
        return chosen or (self._random.choice(others) if others else None)

    def _of_the_next_kind(self, there: Sequence[Victim]) -> Victim | None:
        """A victim of the first kind in the queue that has a living process."""
        for place, kind in enumerate(self._turns):
            of_kind = [victim for victim in there if victim.kind is kind]
            if of_kind:
                del self._turns[place]
                return self._random.choice(of_kind)
        return None
