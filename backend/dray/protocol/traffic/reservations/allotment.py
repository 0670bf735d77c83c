"""Allotment: grants a district's requests from its table, in the order of their ranks."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from operator import itemgetter

import msgspec

from dray.messages.floor.traffic import Blocked, PlaceRequested
from dray.protocol.traffic.reservations.reservation_table import ReservationTable


class Hindrance(msgspec.Struct, frozen=True, gc=False):
    """Why a vehicle is not granted its next group."""

    blocked: Blocked
    by: str
    """The vehicle that holds a place of the group, or goes first; the vehicle itself while its position is unknown."""
    at: str
    """The place."""
    holds: bool
    """Whether `by` holds that place; otherwise it only goes first."""


FREE = Hindrance(Blocked.NO, "", "", holds=False)


def allot(
    table: ReservationTable,
    requests: Mapping[str, PlaceRequested],
    is_silent: Callable[[str], bool],
    is_within_reach: Callable[[str, Sequence[str]], bool],
) -> tuple[dict[str, Hindrance], set[str]]:
    """Grant every group that is free and whose turn it is; changes the table.

    A group is granted as a whole, when all its places are free. While a vehicle waits for a holder, the free places of its group
    are kept from less urgent vehicles, or it could wait for ever. Vehicles that stand in its way may still take them.
    Nothing is kept while the holder is docked or silent.

    Args:
        table: of the district.
        requests: the newest one of every vehicle.
        is_silent: whether a vehicle's heartbeats have stopped.
        is_within_reach: whether a vehicle may have these places, by its last known position.

    Returns:
        Vehicle -> hindrance, for vehicles that did not get all that they want; and the vehicles that were granted something.
    """
    hindrances: dict[str, Hindrance] = {}
    granted: set[str] = set()
    kept: dict[str, str] = {}
    """Place -> the vehicle for which it is kept."""
    waiting = [(request.rank, atv, request) for atv, request in requests.items() if request.groups]
    waiting.sort(key=itemgetter(0, 1))
    for _, atv, request in waiting:
        for group in request.groups:
            missing = [place for place in group if table.holder(place) != atv]
            if not missing:
                continue
            if is_within_reach(atv, missing):
                hindrance = _hindrance(table, requests, is_silent, atv, missing, kept)
            else:
                hindrance = Hindrance(Blocked.WAIT, atv, missing[0], holds=False)
            if hindrance is None:
                table.grant(atv, missing, request.mark)
                granted.add(atv)
                continue
            hindrances[atv] = hindrance
            if hindrance.holds and hindrance.blocked is Blocked.WAIT:
                for place in missing:
                    kept.setdefault(place, atv)
            break
    return hindrances, granted


def _hindrance(
    table: ReservationTable,
    requests: Mapping[str, PlaceRequested],
    is_silent: Callable[[str], bool],
    atv: str,
    missing: list[str],
    kept: Mapping[str, str],
) -> Hindrance | None:
    """What keeps a vehicle from the missing places of a group; None for nothing."""
    for place in missing:
        holder = table.holder(place)
        if holder:
            request = requests.get(holder)
            if is_silent(holder):
                why = Blocked.SILENT
            elif request is not None and request.docked:
                why = Blocked.DOCKED
            else:
                why = Blocked.WAIT
            return Hindrance(why, holder, place, holds=True)
    rank = requests[atv].rank
    for place in missing:
        first = kept.get(place)
        if (
            first is not None
            and requests[first].rank < rank
            and not _is_in_its_way(table, requests[first], atv)
        ):
            return Hindrance(Blocked.WAIT, first, place, holds=False)
    return None


def _is_in_its_way(table: ReservationTable, first: PlaceRequested, atv: str) -> bool:
    """Whether a vehicle holds a place that a more urgent one waits for: then it must be let out."""
    return any(table.holder(place) == atv for group in first.groups for place in group)
