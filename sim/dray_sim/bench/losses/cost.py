"""The cost of a kill: how long the process was away, and how its work went on. Pure."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from dray.messages import Event, Role
from dray.messages.fact import CarrierChanged, ContractTaken, GoalLost, PhaseEntered, TaskClosed, WatchLost
from dray_sim.bench.losses.victims import Kind, Victim
from dray_sim.bench.losses.works import Works

KEPT = "kept"
TAKEN_OVER = "taken over by the secondary"
ANNOUNCED = "announced anew"
WITHDRAWN = "withdrawn"
WATCHED_ANEW = "another one watches"
GIVEN_AWAY = "given to another machine"


@dataclass(frozen=True, slots=True)
class Kill:
    """One process was killed.

    Attributes:
        victim: the process, and what it was doing.
        at_s: when (plant clock).
        away_s: until its next life was on the bus, in real seconds; None when that was not seen.
    """

    victim: Victim
    at_s: float
    away_s: float | None


@dataclass(frozen=True, slots=True)
class Fate:
    """How one work of a victim went on.

    Attributes:
        what: the outcome, in a few words.
        at_s: when it went on, or was over (plant clock).
    """

    what: str
    at_s: float


def fates(kill: Kill, works: Works) -> list[Fate]:
    """How each work of a victim went on.

    Args:
        kill: a work that the victim had ended just before, and not yet reported, has no fate.
        works: all works of the campaign.
    """
    look = _LOOKS.get(kill.victim.kind)
    if look is None:
        return []
    found = (look(kill.victim.name, works.after(work, kill.at_s)) for work in kill.victim.work)
    return [fate for fate in found if fate is not None]


def _carried(carrier: str, told: Sequence[Event]) -> Fate | None:
    """A task whose primary was killed."""
    announced = False
    for event in told:
        match event.fact:
            case CarrierChanged(replaced=replaced, carrier=other) if replaced == carrier:
                if other:
                    return Fate(TAKEN_OVER, event.at_s)
                announced = True
            case ContractTaken(role=Role.PRIMARY) if announced:
                return Fate(ANNOUNCED, event.at_s)
            case PhaseEntered() if event.agent == carrier and not announced:
                return Fate(KEPT, event.at_s)
            case TaskClosed(outcome=outcome):
                return Fate(KEPT if outcome == "delivered" else WITHDRAWN, event.at_s)
            case _:
                pass
    return None


def _watched(secondary: str, told: Sequence[Event]) -> Fate | None:
    """A task whose secondary was killed."""
    lost = False
    for event in told:
        match event.fact:
            case WatchLost(secondary=gone) if gone == secondary:
                lost = True
            case ContractTaken(role=Role.SECONDARY) if lost:
                return Fate(WATCHED_ANEW, event.at_s)
            case TaskClosed():
                return Fate(KEPT, event.at_s)
            case _:
                pass
    return None


def _made(machine: str, told: Sequence[Event]) -> Fate | None:
    """A goal whose machine was killed."""
    for event in told:
        match event.fact:
            case GoalLost(machine=gone) if gone == machine:
                return Fate(GIVEN_AWAY, event.at_s)
            case _ if event.agent == machine:
                return Fate(KEPT, event.at_s)
            case _:
                pass
    return None


_LOOKS: Mapping[Kind, Callable[[str, Sequence[Event]], Fate | None]] = {
    Kind.FETCHING: _carried,
    Kind.LOADED: _carried,
    Kind.WATCHING: _watched,
    Kind.CREW_VEHICLE: _carried,
    Kind.CREW_MACHINE: _made,
    Kind.VEHICLE_AWAY: _carried,
    Kind.MACHINE: _made,
    Kind.MACHINE_AWAY: _made,
}
