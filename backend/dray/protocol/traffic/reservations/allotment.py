"""Who is granted what next: the requests of a district, in the order of their ranks, against its table."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from operator import itemgetter

import msgspec

from dray.messages.floor.traffic import Blocked, PlaceRequested
from dray.protocol.traffic.reservations.reservation_table import ReservationTable


class Hindrance(msgspec.Struct, frozen=True, gc=False):
    """Why a vehicle does not get its next group."""

    blocked: Blocked
    by: str
    """Who holds a place of it, or goes first."""
    at: str
    """The place."""
    holds: bool
    """Whether it holds that place; else it only goes first."""


FREE = Hindrance(Blocked.NO, "", "", holds=False)


def allot(
    table: ReservationTable,
    requests: Mapping[str, PlaceRequested],
    is_silent: Callable[[str], bool],
    is_within_reach: Callable[[str, Sequence[str]], bool],
) -> tuple[dict[str, Hindrance], set[str]]:
    """Grant every group that is free and whose turn it is; the table is changed.

    A group is granted when all of it is free, and whole. The most urgent vehicle that waits for several places has those of them
    that are free kept for it, except from vehicles that stand in its own way and from those that wait on a docked one's work: else
    a row of single places taken behind one another would let it wait for ever.

    Args:
        table: of the district.
        requests: the newest one of every vehicle.
        is_silent: whether nobody has heard of a vehicle for a while.
        is_within_reach: whether a vehicle may have these places, as far as one knows where it is.

    Returns:
        Vehicle -> what keeps it from its next group, for those that are not granted all that they want; and those that were
        granted something.
    """
    hindrances: dict[str, Hindrance] = {}
    granted: set[str] = set()
    kept: dict[str, str] = {}
    """Place -> for whom it is kept."""
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
    """What keeps a vehicle from the places that it misses of a group; None for nothing."""
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
    """Whether a vehicle holds something that a more urgent one waits for: it must be let out."""
    return any(table.holder(place) == atv for group in first.groups for place in group)
