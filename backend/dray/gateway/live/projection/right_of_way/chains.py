"""Chains of waits: who waits for whom, down to the vehicle that blocks all of them. Pure."""

from __future__ import annotations

from collections.abc import Mapping

import msgspec

from dray.gateway.live.views.floor.wait import WaitKind

NAMED = 8
"""Maximum vehicles named in a chain: nobody reads more."""


class Standing(msgspec.Struct, frozen=True, gc=False):
    """The state of one vehicle, as far as others may wait for it."""

    kind: WaitKind
    """Why others would wait for it, if it waited for nobody itself."""
    waits: bool = False
    waits_for: str = ""
    """The vehicle that it waits for; empty if none or unknown."""


class Chain(msgspec.Struct, frozen=True, gc=False):
    """The vehicles that one vehicle waits for."""

    kind: WaitKind
    """What blocks the last one; the vehicle itself if none is ahead."""
    ahead: tuple[str, ...] = ()
    """The vehicle that it waits for, the one that that waits for, and so on: at most `NAMED`."""
    last: str = ""
    """The vehicle at the end; empty if none is ahead."""
    count: int = 0
    """Number of vehicles ahead."""
    circle: tuple[str, ...] = ()
    """Vehicles that wait in a circle, each for the next and the last for the first. The least id comes
    first."""


UNKNOWN = Chain("silent")


def chains_of(vehicles: Mapping[str, Standing]) -> dict[str, Chain]:
    """The chains of all vehicles that wait.

    Args:
        vehicles: all known vehicles, by id. A vehicle waited for but not among them counts as silent.
    """
    ends: dict[str, Chain] = {}
    for first, standing in vehicles.items():
        if standing.waits and first not in ends:
            _follow(first, vehicles, ends)
    return {atv: chain for atv, chain in ends.items() if vehicles[atv].waits}


def _follow(first: str, vehicles: Mapping[str, Standing], ends: dict[str, Chain]) -> None:
    """Find the end of a chain, and with it the chains of all vehicles along it."""
    path: dict[str, None] = {}
    here = first
    while here in vehicles and here not in ends and here not in path and vehicles[here].waits_for:
        path[here] = None
        here = vehicles[here].waits_for
    if here in path:
        onward = list(path)
        _close(onward[onward.index(here) :], ends)
    elif here not in ends and here in vehicles:
        ends[here] = Chain(vehicles[here].kind)
    for atv in reversed(path):
        if atv not in ends:
            ends[atv] = _behind(vehicles[atv].waits_for, ends)


def _behind(atv: str, ends: dict[str, Chain]) -> Chain:
    """The chain of a vehicle that waits for this one."""
    after = ends.get(atv, UNKNOWN)
    return Chain(
        after.kind, (atv, *after.ahead)[:NAMED], after.last or atv, after.count + 1, circle=after.circle
    )


def _close(members: list[str], ends: dict[str, Chain]) -> None:
    """Set the chains of a circle: each vehicle names the others, in the order of the circle."""
    least = members.index(min(members))
    circle = (*members[least:], *members[:least])
    others, twice = len(circle) - 1, circle * 2
    for place, atv in enumerate(circle):
        ahead = twice[place + 1 : place + 1 + min(others, NAMED)]
        ends[atv] = Chain("circle", ahead, circle[place - 1] if others else "", others, circle)
