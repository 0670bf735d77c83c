"""Victims: which process is killed next, and what it was doing at that moment."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from random import Random

from dray.cli.fleet.folder import GATEWAY, HISTORIAN
from dray.messages import AtvHeartbeat, MachineHeartbeat, Phase
from dray.messages.keys import STRATEGIST


class Kind(StrEnum):
    """What a process was when it was killed.

    The database's turn is before those who cannot start without it: it is not killed while they are away.
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
"""What a victim with work is when it is not started again for a long time."""

LASTING = frozenset(STAYS_AWAY.values())
"""It is their turn so many times, and chance never names them: each is away for long."""


@dataclass(frozen=True, slots=True)
class Victim:
    """A process that may be killed.

    Attributes:
        name: its agent's.
        kind: what it does at this moment, by its own word.
        work: the task that it carries, the tasks that it watches, or the goals that it makes.
        crew: who is killed at the same moment: both sides of a contract lose what they hold of it in their heads.
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
    """A machine with all that carry for it, by their last words; None when nobody does."""
    members = tuple(
        Victim(each.atv, Kind.CREW_VEHICLE, (each.task.task,))
        for each in vehicles
        if each.task is not None and each.task.coordinator == heartbeat.machine
    )
    if not members:
        return None
    return replace(machine(heartbeat), kind=Kind.CREW_MACHINE, crew=members)


class Rota:
    """Whose turn it is: every kind so many times in turn, then whoever chance names.

    Args:
        random: the only source of chance.
        turns: how often it is each kind's turn.
    """

    def __init__(self, random: Random, turns: Mapping[Kind, int]) -> None:
        self._random = random
        rounds = range(max(turns.values()))
        self._turns = [kind for turn in rounds for kind in Kind if turn < turns.get(kind, 0)]

    def choose(self, living: Iterable[Victim]) -> Victim | None:
        """The next one; None when nobody lives."""
        chosen = self._of_the_next_kind(there := sorted(living, key=lambda victim: victim.name))
        others = [victim for victim in there if victim.kind not in LASTING]
        return chosen or (self._random.choice(others) if others else None)

    def _of_the_next_kind(self, there: Sequence[Victim]) -> Victim | None:
        """Of the first kind that waits for its turn and that somebody is of now."""
        for place, kind in enumerate(self._turns):
            of_kind = [victim for victim in there if victim.kind is kind]
            if of_kind:
                del self._turns[place]
                return self._random.choice(of_kind)
        return None
