"""Chains of waiting: who waits for whom, down to the one that holds all of them up. Pure."""

from __future__ import annotations

from collections.abc import Mapping

import msgspec

from dray.gateway.live.views.floor.wait import WaitKind

NAMED = 8
"""Vehicles of a chain that are named at most: nobody reads more."""


class Standing(msgspec.Struct, frozen=True, gc=False):
    """What is known of one vehicle, as far as others may wait for it."""

    kind: WaitKind
    """Why others would wait for it, if it waited for nobody."""
    waits: bool = False
    waits_for: str = ""
    """Empty where it does not wait, or nobody knows for whom."""


class Chain(msgspec.Struct, frozen=True, gc=False):
    """For whom one vehicle waits."""

    kind: WaitKind
    """What holds up the last one; the vehicle itself where there is nobody ahead."""
    ahead: tuple[str, ...] = ()
    """Whom it waits for, whom that one waits for, and so on: the first `NAMED` at most."""
    last: str = ""
    """The one at the end; empty where there is nobody ahead."""
    count: int = 0
    """How many there are ahead."""
    circle: tuple[str, ...] = ()
    """Those that wait for one another, each for the next one and the last for the first, which is the least by its id."""


UNKNOWN = Chain("silent")


def chains_of(vehicles: Mapping[str, Standing]) -> dict[str, Chain]:
    """The chains of all that wait.

    Args:
        vehicles: all that are known, by id. Who is waited for and is not among them counts as silent.
    """
    ends: dict[str, Chain] = {}
    for first, standing in vehicles.items():
        if standing.waits and first not in ends:
            _follow(first, vehicles, ends)
    return {atv: chain for atv, chain in ends.items() if vehicles[atv].waits}


def _follow(first: str, vehicles: Mapping[str, Standing], ends: dict[str, Chain]) -> None:
    """Find the end of a chain, and with it those of all on the way there."""
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
    """The chain of one that waits for this vehicle."""
    after = ends.get(atv, UNKNOWN)
    return Chain(
        after.kind, (atv, *after.ahead)[:NAMED], after.last or atv, after.count + 1, circle=after.circle
    )


def _close(members: list[str], ends: dict[str, Chain]) -> None:
    """Those that wait in a circle: each names the others, in the order in which they wait."""
    least = members.index(min(members))
    circle = (*members[least:], *members[:least])
    others, twice = len(circle) - 1, circle * 2
    for place, atv in enumerate(circle):
        ahead = twice[place + 1 : place + 1 + min(others, NAMED)]
        ends[atv] = Chain("circle", ahead, circle[place - 1] if others else "", others, circle)
